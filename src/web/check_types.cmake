# The types of the page and of its tests: cmake -DNODE=… -DNPM=… -DWORK=… -P …
include(${CMAKE_CURRENT_LIST_DIR}/fetch_for_tests.cmake)
if(NOT fetched)
  message(STATUS "the types are not checked: npm can't fetch the compiler:\n${log}")
  return()
endif()
file(REMOVE_RECURSE ${WORK}/types)
file(COPY src test tsconfig.json DESTINATION ${WORK}/types)
execute_process(COMMAND ${NODE} ${WORK}/node_modules/typescript/bin/tsc --noEmit -p ${WORK}/types COMMAND_ERROR_IS_FATAL ANY)
