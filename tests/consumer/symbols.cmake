# The shared libraries export the public interface and keep to themselves what they are made of.
if(NOT shared)
  message("static libraries: nothing to check")
  return()
endif()
foreach(library graspctx graspctx_io)
  execute_process(COMMAND nm --dynamic --demangle --defined-only --format=posix
                          "${work}/prefix/${libdir}/lib${library}.so"
                  OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
  if(NOT symbols MATCHES "graspctx::")
    message(FATAL_ERROR "lib${library}.so exports no symbol of graspctx")
  endif()
  string(REGEX REPLACE "[][;]" "." symbols "${symbols}")  # they have a meaning in CMake's lists
  string(REPLACE "\n" ";" symbols "${symbols}")
  foreach(symbol ${symbols})
    if(symbol MATCHES "(^| )svm_|nlohmann|graspctx::detail|YAML|CLI::")
      message(SEND_ERROR "lib${library}.so exports ${symbol}")
    elseif(symbol MATCHES " [TDB] " AND NOT symbol MATCHES "graspctx::|^(__bss_start|_edata|_end) ")
      message(SEND_ERROR "lib${library}.so exports ${symbol}")
    endif()
  endforeach()
endforeach()
