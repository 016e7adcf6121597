# find_package(graspctx), build and run; the README's C++ example is built along.
include("${CMAKE_CURRENT_LIST_DIR}/readme_example.cmake")
write_readme_example("${source}/README.md" "${work}/readme_example.cpp")

set(project_build "${work}/cmake_package")
execute_process(COMMAND "${CMAKE_COMMAND}" -S "${source}/tests/consumer" -B "${project_build}" -G "${generator}"
                        -D CMAKE_CXX_COMPILER=${compiler} -D CMAKE_PREFIX_PATH=${work}/prefix
                        -D README_EXAMPLE=${work}/readme_example.cpp
                COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${CMAKE_COMMAND}" --build "${project_build}" COMMAND_ERROR_IS_FATAL ANY)
foreach(program core_consumer consumer)
  execute_process(COMMAND "${project_build}/${program}" WORKING_DIRECTORY "${work}" COMMAND_ERROR_IS_FATAL ANY)
endforeach()

execute_process(COMMAND "${project_build}/readme_example" left.png right.png calib.txt
                WORKING_DIRECTORY "${source}/examples/data/mug" OUTPUT_VARIABLE grasps COMMAND_ERROR_IS_FATAL ANY)
if(NOT grasps MATCHES "^0\\.[0-9]+ at ")
  message(FATAL_ERROR "the README's example printed: ${grasps}")
endif()
