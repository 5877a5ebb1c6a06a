# Fetches into WORK what the tests need of npm, once for each package-lock.json. `fetched` is false when npm can't, and `log` says why.
# The tests run on copies, in or below WORK: the source tree stays as it is.
file(SHA256 package-lock.json wanted)
set(there "")
if(EXISTS ${WORK}/fetched)
  file(READ ${WORK}/fetched there)
endif()
set(fetched TRUE)
if(NOT there STREQUAL wanted)
  file(REMOVE_RECURSE ${WORK})
  file(COPY package.json package-lock.json .npmrc DESTINATION ${WORK})
  execute_process(COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --loglevel=error WORKING_DIRECTORY ${WORK}
    RESULT_VARIABLE result OUTPUT_VARIABLE log ERROR_VARIABLE log TIMEOUT 200)
  if(result EQUAL 0)
    file(WRITE ${WORK}/fetched ${wanted})
  else()
    set(fetched FALSE)
  endif()
endif()
