# Public headers ask for OpenCV's core, Eigen and the standard library, and for nothing else.
file(GLOB_RECURSE headers "${work}/prefix/include/*.hpp")
list(LENGTH headers count)
if(count LESS 20)
  message(FATAL_ERROR "only ${count} headers installed")
endif()
foreach(header ${headers})
  file(STRINGS "${header}" includes REGEX "^#include")
  foreach(line ${includes})
    if(NOT line MATCHES "^#include (<[a-z_0-9]+>|<Eigen/[A-Za-z]+>|<opencv2/core\\.hpp>|\"graspctx/[a-z_/]+\\.hpp\")$")
      message(SEND_ERROR "${header}: ${line}")
    endif()
  endforeach()
endforeach()

# Each of them compiles by itself.
execute_process(COMMAND "${CMAKE_COMMAND}" --build "${build}" --target all_verify_interface_header_sets
                COMMAND_ERROR_IS_FATAL ANY)
