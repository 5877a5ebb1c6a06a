# Installs BUILD into a folder of its own and uses it from there, as a stranger would.
# cmake -DBUILD=... -DSOURCE=... -DCXX=... -DFLAGS=... -P run.cmake
set(prefix ${BUILD}/package/prefix)
file(REMOVE_RECURSE ${BUILD}/package)

function(run)
  execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    string(REPLACE ";" " " command "${ARGN}")
    message(FATAL_ERROR "${command}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
foreach(file bin/anogated lib/systemd/system/anogated.service lib/sysusers.d/anogate.conf lib/udev/rules.d/60-anogate.rules etc/anogate/anogate.json)
  if(NOT EXISTS ${prefix}/${file})
    message(FATAL_ERROR "${file} was not installed")
  endif()
endforeach()

file(WRITE ${prefix}/etc/anogate/anogate.json "mine")
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
file(READ ${prefix}/etc/anogate/anogate.json configuration)
if(NOT configuration STREQUAL "mine")
  message(FATAL_ERROR "the configuration of the user was overwritten")
endif()

run(${CMAKE_COMMAND} -G Ninja -S ${SOURCE} -B ${BUILD}/package/build -DCMAKE_PREFIX_PATH=${prefix}
    -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_CXX_FLAGS=${FLAGS})
run(${CMAKE_COMMAND} --build ${BUILD}/package/build)
run(${BUILD}/package/build/first_frame)
if(NOT output STREQUAL "E0 from the host\n")
  message(FATAL_ERROR "first_frame printed: ${output}")
endif()
