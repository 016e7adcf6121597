# Install into one folder and move the tree to another: nothing in it may remember where it was.
file(REMOVE_RECURSE "${work}")
execute_process(COMMAND "${CMAKE_COMMAND}" --install "${build}" --prefix "${work}/first" COMMAND_ERROR_IS_FATAL ANY
                OUTPUT_QUIET)
file(RENAME "${work}/first" "${work}/prefix")

set(expected "include/graspctx/graspctx.hpp" "include/graspctx/version.hpp" "include/graspctx/io/model_file.hpp"
             "${libdir}/cmake/graspctx/graspctxConfig.cmake" "${libdir}/cmake/graspctx/graspctxConfigVersion.cmake"
             "${libdir}/pkgconfig/graspctx.pc" "${libdir}/pkgconfig/graspctx_io.pc" "share/doc/graspctx/LICENSE")
file(GLOB models RELATIVE "${source}" "${source}/models/*.safetensors")
foreach(model ${models})
  list(APPEND expected "share/graspctx/${model}")
endforeach()
foreach(file ${expected})
  if(NOT EXISTS "${work}/prefix/${file}")
    message(FATAL_ERROR "not installed: ${file}")
  endif()
endforeach()
