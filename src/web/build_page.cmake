# Fetches what the page is made of, when that has changed, and builds the page: cmake -DSOURCE=… -DPAGE=… -DMODE=auto|on -DNPM=… -DNODE=… -P …
# The source tree stays as it is. With auto, a computer without a network gets a gateway without a page.
set(fetched ${PAGE}-modules)

function(fail words log)
  if(MODE STREQUAL "on")
    message(FATAL_ERROR "${words}:\n${log}")
  endif()
  message(WARNING "${words}; anogated is built without it. What was said:\n${log}")
endfunction()

file(SHA256 ${SOURCE}/package-lock.json wanted)
set(there "")
if(EXISTS ${fetched}/fetched)
  file(READ ${fetched}/fetched there)
endif()
if(NOT there STREQUAL wanted)
  file(REMOVE_RECURSE ${fetched})
  file(COPY ${SOURCE}/package.json ${SOURCE}/package-lock.json ${SOURCE}/.npmrc DESTINATION ${fetched})
  execute_process(COMMAND ${NPM} ci --omit=dev --ignore-scripts --no-audit --no-fund --loglevel=error WORKING_DIRECTORY ${fetched}
    RESULT_VARIABLE result OUTPUT_VARIABLE log ERROR_VARIABLE log TIMEOUT 300)
  if(NOT result EQUAL 0)
    fail("The page for browsers can't be built: npm can't fetch what it is made of" "${log}")
    return()
  endif()
  file(WRITE ${fetched}/fetched ${wanted})
endif()
execute_process(COMMAND ${NODE} ${SOURCE}/build.mjs --modules ${fetched}/node_modules --out ${PAGE}
  RESULT_VARIABLE result OUTPUT_VARIABLE log ERROR_VARIABLE log)
if(NOT result EQUAL 0)
  fail("The page for browsers can't be built" "${log}")
  return()
endif()
message(STATUS "${log}")
