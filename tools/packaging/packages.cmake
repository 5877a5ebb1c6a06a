# The Debian packages anogate, libano-dev and, where Fast DDS is, anogate-ros2, and where libmosquitto and SQLite are, anogate-mqtt; tools/package sets ANOGATE_PACKAGE to the folder that holds what it wrote for them:
# version, changelog and the bills of materials.
file(READ ${ANOGATE_PACKAGE}/version package_version)
string(STRIP "${package_version}" package_version)

set(packages anogate libano-dev)
foreach(bridge anogate-ros2 anogate-mqtt anogate-mavlink)
  if(TARGET ${bridge})
    list(APPEND packages ${bridge})
  endif()
endforeach()
foreach(package ${packages})
  install(FILES ${PROJECT_SOURCE_DIR}/tools/packaging/copyright ${ANOGATE_PACKAGE}/changelog.gz
    DESTINATION share/doc/${package} COMPONENT ${package})
  if(NOT package STREQUAL libano-dev)
    install(FILES ${ANOGATE_PACKAGE}/${package}.spdx.json DESTINATION share/doc/${package} RENAME sbom.spdx.json COMPONENT ${package})
  endif()
endforeach()
install(FILES ${PROJECT_SOURCE_DIR}/tools/packaging/lintian-overrides DESTINATION share/lintian/overrides RENAME anogate COMPONENT anogate)

# Debian has manual pages compressed.
install(CODE [[
  foreach(page man8/anogated.8 man1/anoctl.1 man5/anogate.json.5 man7/anogate-api.7)
    execute_process(COMMAND gzip -9nf "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/share/man/${page}" COMMAND_ERROR_IS_FATAL ANY)
  endforeach()
]] COMPONENT anogate)

foreach(bridge anogate-ros2 anogate-mqtt anogate-mavlink)
  if(TARGET ${bridge})
    install(CODE "set(bridge ${bridge})" COMPONENT ${bridge})
    install(CODE [[
      execute_process(COMMAND gzip -9nf "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/share/man/man8/${bridge}.8" COMMAND_ERROR_IS_FATAL ANY)
    ]] COMPONENT ${bridge})
  endif()
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_OUTPUT_FILE_PREFIX ${ANOGATE_PACKAGE})
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL ${packages})
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")    # each package has its own, in its first line
set(CPACK_PACKAGE_CONTACT "anogate developers <anogate@users.noreply.github.com>")
set(CPACK_DEBIAN_PACKAGE_VERSION ${package_version})
set(CPACK_DEBIAN_PACKAGE_MAINTAINER ${CPACK_PACKAGE_CONTACT})
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
if(ANOGATE_PACKAGE_ARCHITECTURE)
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE ${ANOGATE_PACKAGE_ARCHITECTURE})
endif()

set(CPACK_DEBIAN_ANOGATE_PACKAGE_NAME anogate)
set(CPACK_DEBIAN_ANOGATE_PACKAGE_SECTION comm)
# Listed here because dpkg-shlibdeps names only the packages of this system: check-portable verifies libraries and versions. 32-bit Debian
# 13 has libssl3t64 alone; its functions with time_t, which differ there, are not used.
set(CPACK_DEBIAN_ANOGATE_PACKAGE_DEPENDS "systemd | systemd-standalone-sysusers | systemd-sysusers")
if(ANOGATE_PACKAGE_RELEASE STREQUAL "this")
  set(CPACK_DEBIAN_ANOGATE_PACKAGE_SHLIBDEPS ON)
else()
  string(PREPEND CPACK_DEBIAN_ANOGATE_PACKAGE_DEPENDS "libc6 (>= 2.35), libgcc-s1 (>= 3.4), libqrencode4 (>= 3.2.0), \
libssl3 (>= 3.0.0) | libssl3t64 (>= 3.0.0), libstdc++6 (>= 12), ")
endif()
set(CPACK_DEBIAN_ANOGATE_PACKAGE_SUGGESTS "can-utils, gpiod, wireguard-tools")
set(CPACK_DEBIAN_ANOGATE_PACKAGE_CONTROL_EXTRA
  ${PROJECT_SOURCE_DIR}/tools/packaging/conffiles ${PROJECT_SOURCE_DIR}/tools/packaging/preinst ${PROJECT_SOURCE_DIR}/tools/packaging/postinst
  ${PROJECT_SOURCE_DIR}/tools/packaging/prerm ${PROJECT_SOURCE_DIR}/tools/packaging/postrm)
set(CPACK_COMPONENT_ANOGATE_DESCRIPTION "gateway for the ANO V8 protocol
Connects devices and programs that use ANO V8 into one network: serial ports,
CAN buses and UDP peers. Each frame is forwarded to its destination address,
and frames of devices without a network are tunneled over IP.
.
Includes anoctl, a command-line tool for frames and the gateway, and a systemd
service that must be enabled before it starts.")

set(CPACK_DEBIAN_LIBANO-DEV_PACKAGE_NAME libano-dev)
set(CPACK_DEBIAN_LIBANO-DEV_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_LIBANO-DEV_DESCRIPTION "library for the ANO V8 protocol
Finds, decodes and encodes ANO V8 frames, with all messages by name. Written
in C++20, requires only the standard library. Contains a static library,
headers and the files for find_package(ano) in CMake.")
# Of Debian 12 alone: the interface of Fast DDS differs in every release. The control socket belongs to the group of anogate's package.
set(CPACK_DEBIAN_ANOGATE-ROS2_PACKAGE_NAME anogate-ros2)
set(CPACK_DEBIAN_ANOGATE-ROS2_PACKAGE_SECTION comm)
set(CPACK_DEBIAN_ANOGATE-ROS2_PACKAGE_DEPENDS "anogate, libc6 (>= 2.35), libfastrtps2.9, libgcc-s1 (>= 3.4), \
libssl3 (>= 3.0.0), libstdc++6 (>= 12)")
set(CPACK_DEBIAN_ANOGATE-ROS2_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/tools/packaging/ros2/postinst
  ${PROJECT_SOURCE_DIR}/tools/packaging/ros2/prerm ${PROJECT_SOURCE_DIR}/tools/packaging/ros2/postrm)
set(CPACK_COMPONENT_ANOGATE-ROS2_DESCRIPTION "ROS 2 topics of the devices of anogate
Publishes the messages of ANO V8 devices as standard ROS 2 messages over DDS,
and passes velocities, sticks and commands of ROS 2 nodes to them if the
configuration allows it. ROS 2 itself is not needed.
.
Includes a systemd service that must be enabled before it starts.")
set(CPACK_DEBIAN_ANOGATE-MAVLINK_PACKAGE_NAME anogate-mavlink)
set(CPACK_DEBIAN_ANOGATE-MAVLINK_PACKAGE_SECTION comm)
set(CPACK_DEBIAN_ANOGATE-MAVLINK_PACKAGE_DEPENDS "anogate, libc6 (>= 2.35), libgcc-s1 (>= 3.4), \
libssl3 (>= 3.0.0) | libssl3t64 (>= 3.0.0), libstdc++6 (>= 12)")
set(CPACK_DEBIAN_ANOGATE-MAVLINK_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/tools/packaging/mavlink/postinst
  ${PROJECT_SOURCE_DIR}/tools/packaging/mavlink/prerm ${PROJECT_SOURCE_DIR}/tools/packaging/mavlink/postrm)
set(CPACK_COMPONENT_ANOGATE-MAVLINK_DESCRIPTION "devices of anogate in MAVLink ground stations
Shows ANO V8 devices to QGroundControl and other ground stations: telemetry,
parameters, missions and commands over MAVLink. A station steers a device only
if the configuration allows it.
.
Includes a systemd service that must be enabled before it starts.")
# Of Debian 12 alone as well: built with its libraries.
set(CPACK_DEBIAN_ANOGATE-MQTT_PACKAGE_NAME anogate-mqtt)
set(CPACK_DEBIAN_ANOGATE-MQTT_PACKAGE_SECTION comm)
set(CPACK_DEBIAN_ANOGATE-MQTT_PACKAGE_DEPENDS "anogate, libc6 (>= 2.35), libgcc-s1 (>= 3.4), libmosquitto1 (>= 2.0.11), \
libsqlite3-0 (>= 3.40), libssl3 (>= 3.0.0), libstdc++6 (>= 12)")
set(CPACK_DEBIAN_ANOGATE-MQTT_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/tools/packaging/mqtt/postinst
  ${PROJECT_SOURCE_DIR}/tools/packaging/mqtt/prerm ${PROJECT_SOURCE_DIR}/tools/packaging/mqtt/postrm)
set(CPACK_COMPONENT_ANOGATE-MQTT_DESCRIPTION "MQTT uplink of the devices of anogate
Publishes the messages of ANO V8 devices to an MQTT 5 broker, stores them while
it can't be reached, and executes requests of its clients if the configuration
allows it. Also collects the messages of a fleet.
.
Includes a systemd service that must be enabled before it starts.")
include(CPack)
