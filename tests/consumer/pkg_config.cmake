# The one line of people who use no build system.
set(ENV{PKG_CONFIG_PATH} "${work}/prefix/${libdir}/pkgconfig")
set(static "")
if(NOT shared)
  set(static "--static")
endif()
foreach(pair "core_consumer graspctx" "consumer graspctx_io")
  separate_arguments(pair)
  list(GET pair 0 program)
  list(GET pair 1 package)
  execute_process(COMMAND pkg-config ${static} --cflags --libs ${package} OUTPUT_VARIABLE flags
                  OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags)
  execute_process(COMMAND "${compiler}" -std=c++17 "${source}/tests/consumer/${program}.cpp" -o "${work}/${program}"
                          ${flags} "-Wl,-rpath,${work}/prefix/${libdir}"
                  COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND "${work}/${program}" WORKING_DIRECTORY "${work}" COMMAND_ERROR_IS_FATAL ANY)
endforeach()
