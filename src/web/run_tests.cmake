# The tests of the pure parts, with what the page was built of: cmake -DNODE=… -DMODULES=… -DTESTS=… -P run_tests.cmake
if(NOT EXISTS ${MODULES}/esbuild)
  message(STATUS "the page was not built: nothing to test it with")
  return()
endif()
execute_process(COMMAND ${NODE} build.mjs --tests --modules ${MODULES} --out ${TESTS} COMMAND_ERROR_IS_FATAL ANY)
file(GLOB tests ${TESTS}/*.test.mjs)
execute_process(COMMAND ${NODE} --test ${tests} COMMAND_ERROR_IS_FATAL ANY)
