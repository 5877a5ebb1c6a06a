# Installs BUILD into its own folder and uses it from there like an external project.
# cmake -DBUILD=... -DSOURCE=... -DCXX=... -DFLAGS=... -P run.cmake
cmake_minimum_required(VERSION 3.22)
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
foreach(file bin/anogated lib/systemd/system/anogated.service lib/systemd/system/anogated@.service lib/sysusers.d/anogate.conf
    lib/udev/rules.d/60-anogate.rules lib/udev/rules.d/98-anogate-ports.rules etc/anogate/anogate.json etc/anogate/anogate.full.json share/man/man8/anogated.8
    share/man/man1/anoctl.1 share/man/man5/anogate.json.5 share/man/man7/anogate-api.7 share/bash-completion/completions/anoctl
    share/zsh/vendor-completions/_anoctl share/fish/vendor_completions.d/anoctl.fish)
  if(NOT EXISTS ${prefix}/${file})
    message(FATAL_ERROR "${file} was not installed")
  endif()
endforeach()

# With a prefix of its own the unit starts this program with this configuration, which is the one that the program looks for.
file(STRINGS ${prefix}/lib/systemd/system/anogated.service command REGEX "^Exec(Start|Reload)=")
if(NOT command STREQUAL "ExecStart=${prefix}/bin/anogated --config ${prefix}/etc/anogate/anogate.json;ExecReload=${prefix}/bin/anoctl reload")
  message(FATAL_ERROR "the unit has ${command}")
endif()
run(${prefix}/bin/anogated --check)

# The same applies to the unit of instances, each with its own configuration and runtime folder.
file(STRINGS ${prefix}/lib/systemd/system/anogated@.service instance REGEX "^(ExecStart|RuntimeDirectory|Environment|EnvironmentFile)=")
set(expected "EnvironmentFile=-${prefix}/etc/default/anogate" "ExecStart=${prefix}/bin/anogated --config ${prefix}/etc/anogate/%i.json --control /run/anogate-%i/control.sock"
  "RuntimeDirectory=anogate-%i" "Environment=XDG_RUNTIME_DIR=/run/anogate-%i")
if(NOT instance STREQUAL expected)
  message(FATAL_ERROR "the unit of instances has ${instance}")
endif()
run(${prefix}/bin/anogated --help)
if(NOT output MATCHES "${prefix}/etc/anogate/anogate.json")
  message(FATAL_ERROR "anogated looks elsewhere for its configuration:\n${output}")
endif()

# With the system's prefix it is in /etc.
run(${CMAKE_COMMAND} -E env DESTDIR=${BUILD}/package/root ${CMAKE_COMMAND} --install ${BUILD} --prefix /usr)
file(STRINGS ${BUILD}/package/root/usr/lib/systemd/system/anogated.service command REGEX "^Exec(Start|Reload)=")
if(NOT command STREQUAL "ExecStart=/usr/bin/anogated --config /etc/anogate/anogate.json;ExecReload=/usr/bin/anoctl reload")
  message(FATAL_ERROR "the unit has ${command}")
endif()
if(NOT EXISTS ${BUILD}/package/root/etc/anogate/anogate.json)
  message(FATAL_ERROR "no configuration in /etc")
endif()
# The remaining manual steps are printed if the system does not search the prefix, and the manifest lists all files for a later
# removal.
run(${CMAKE_COMMAND} -E env DESTDIR=${BUILD}/package/root ${CMAKE_COMMAND} --install ${BUILD} --prefix "/opt/my anogate")
if(NOT output MATCHES "systemctl link /opt/my anogate/lib/systemd/system/anogated.service ")
  message(FATAL_ERROR "nobody is told of systemctl link:\n${output}")
endif()
file(STRINGS "${BUILD}/package/root/opt/my anogate/lib/systemd/system/anogated.service" command REGEX "^Exec(Start|Reload)=")
if(NOT command STREQUAL "ExecStart=\"/opt/my anogate/bin/anogated\" --config \"/opt/my anogate/etc/anogate/anogate.json\";ExecReload=\"/opt/my anogate/bin/anoctl\" reload")
  message(FATAL_ERROR "the unit has ${command}")
endif()
file(STRINGS ${BUILD}/install_manifest.txt manifest)
foreach(file bin/anogated bin/anoctl lib/systemd/system/anogated.service lib/systemd/system/anogated@.service lib/sysusers.d/anogate.conf)
  if(NOT "/opt/my anogate/${file}" IN_LIST manifest)
    message(FATAL_ERROR "${file} is not in the manifest")
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
run(${BUILD}/package/build/first_question)
if(NOT output STREQUAL "AB FE DC E0 03 00 00 00 00 68 46 again after 200 ms\n")
  message(FATAL_ERROR "first_question printed: ${output}")
endif()

# A device: reports who it is, and acknowledges a parameter, saving it, and a command; after a restart it still has the parameter.
function(answers questions)
  run(sh -c "printf '${questions}' | ${BUILD}/package/build/barometer ${BUILD}/package/values >${BUILD}/package/answers")
  file(READ ${BUILD}/package/answers said HEX)
  foreach(answer ${ARGN})
    if(NOT said MATCHES "${answer}")
      message(FATAL_ERROR "the barometer did not say ${answer}: ${said}")
    endif()
  endforeach()
endfunction()
answers([[\253\376\377\340\003\000\000\000\000\213\073\253\376\041\341\006\000\000\000\000\000\244\301\026\132\253\376\041\340\003\000\020\253\000\150\257\253\376\041\300\003\000\001\000\001\217\155]]
  ab21fee312002164006400000020034261726f6d657465726c89
  ab21fe000300e1165a1e35
  ab21fe000300e068afc42b
  ab21fe000300c08f6d89d7)
answers([[\253\376\041\340\003\000\002\000\000\257\057]] ab21fee1060000000000a4c1167d)

# An external host and an external device, with a wire between them.
run(sh -ec "cd ${BUILD}/package && mkfifo to_device to_host
    build/barometer values <to_device >to_host & build/parameters 0x21 OFFSET=-2.5 RATE=20 >to_device <to_host")
if(NOT output STREQUAL "OFFSET = -2.5, cm, added to the height\nRATE = 20, heights a second\n")
  message(FATAL_ERROR "the host printed: ${output}")
endif()
