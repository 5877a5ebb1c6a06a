# Makes recordings, and reads them by the reader of those who made MCAP:
# cmake -DNODE=… -DNPM=… -DSOURCE=… -DMODULES=… -DFLIGHT=… -DMAKE_FLIGHT=… -P run.cmake
include(${CMAKE_CURRENT_LIST_DIR}/../support/npm_modules.cmake)
fetch_modules(${SOURCE} ${MODULES})
if(fault)
  message(STATUS "the reader of MCAP is not here: ${fault}")
  return()
endif()
file(REMOVE_RECURSE ${FLIGHT})
file(MAKE_DIRECTORY ${FLIGHT})
execute_process(COMMAND ${MAKE_FLIGHT} ${FLIGHT} COMMAND_ERROR_IS_FATAL ANY)
set(ENV{MODULES} ${MODULES})
set(ENV{FLIGHT} ${FLIGHT})
execute_process(COMMAND ${NODE} --test ${SOURCE}/read.mjs COMMAND_ERROR_IS_FATAL ANY)
