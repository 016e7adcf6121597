# Tests of the installation: what a stranger's project sees. The tree is installed, moved, then used.
if(NOT GRASPCTX_INSTALL OR GRASPCTX_SANITIZE)
  return()  # a plain program cannot load libraries built with a sanitizer
endif()

set(consumer_dir "${PROJECT_BINARY_DIR}/consumer")
function(add_consumer_test name)
  add_test(NAME consumer.${name}
           COMMAND "${CMAKE_COMMAND}" -D source=${PROJECT_SOURCE_DIR} -D build=${PROJECT_BINARY_DIR}
                   -D work=${consumer_dir} -D libdir=${CMAKE_INSTALL_LIBDIR} -D compiler=${CMAKE_CXX_COMPILER}
                   -D generator=${CMAKE_GENERATOR} -D shared=${BUILD_SHARED_LIBS} -D cli=${GRASPCTX_BUILD_CLI}
                   -P "${PROJECT_SOURCE_DIR}/tests/consumer/${name}.cmake")
endfunction()

add_consumer_test(install)
set_tests_properties(consumer.install PROPERTIES FIXTURES_SETUP installed)
foreach(name cmake_package pkg_config headers symbols program)
  add_consumer_test(${name})
  set_tests_properties(consumer.${name} PROPERTIES FIXTURES_REQUIRED installed)
endforeach()
