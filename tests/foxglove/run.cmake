# A client of the protocol that we did not write: cmake -DNPM=… -DNODE=… -DMODULES=… -DANOGATED=… -P run.cmake
include(${CMAKE_CURRENT_LIST_DIR}/../support/npm_modules.cmake)
fetch_modules(${CMAKE_CURRENT_LIST_DIR} ${MODULES})
if(fault)
  message(STATUS "skipped: the client is not here: ${fault}")
  return()
endif()
file(COPY ${CMAKE_CURRENT_LIST_DIR}/client.test.mjs DESTINATION ${MODULES})    # modules are looked for beside it
set(ENV{ANOGATED} ${ANOGATED})
execute_process(COMMAND ${NODE} --test ${MODULES}/client.test.mjs COMMAND_ERROR_IS_FATAL ANY)
