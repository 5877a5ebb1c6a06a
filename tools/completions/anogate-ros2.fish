# Completions of fish for anogate-ros2. Generated from its tables of options and commands.
complete -c anogate-ros2 -f
complete -c anogate-ros2 -s h -l help -d 'Print this help and exit'
complete -c anogate-ros2 -s V -l version -d 'print the version'
complete -c anogate-ros2 -s c -l config -r -F -d 'JSON file'
complete -c anogate-ros2 -l control -r -F -d 'the control socket of the gateway '
complete -c anogate-ros2 -l domain -x -d 'the DDS domain, as in ROS_DOMAIN_ID'
complete -c anogate-ros2 -l interface -x -a 'altitude attitude_control check command command_info command_query compass device_info euler firmware flexible1 flexible10 flexible2 flexible3 flexible4 flexible5 flexible6 flexible7 flexible8 flexible9 general_position general_velocity gps image image_feature inertial ip_tunnel ip_tunnel_short log log_value mode module_status optical_flow parameter_command parameter_info parameter_value position power pwm quaternion ranging raw_flow realtime_control remote_control return_home rgb special target_attitude target_velocity velocity waypoint waypoint_read wind' -d 'use only this network interface'
complete -c anogate-ros2 -l list -d 'receive frames for 3 s'
complete -c anogate-ros2 -l check -d 'check the configuration'
complete -c anogate-ros2 -l print-config -d 'print the resulting configuration as a file'
