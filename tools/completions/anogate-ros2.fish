# Completions of fish for anogate-ros2. Generated from its tables of options and commands.
complete -c anogate-ros2 -f
complete -c anogate-ros2 -s h -l help -d 'Print this help and exit'
complete -c anogate-ros2 -s V -l version -d 'print the version'
complete -c anogate-ros2 -s c -l config -r -F -d 'JSON file'
complete -c anogate-ros2 -l control -r -F -d 'the control socket of the gateway '
complete -c anogate-ros2 -l domain -x -d 'the DDS domain, as in ROS_DOMAIN_ID'
complete -c anogate-ros2 -l interface -x -d 'use only this network interface'
complete -c anogate-ros2 -l list -d 'receive frames for 3 s'
complete -c anogate-ros2 -l check -d 'check the configuration'
complete -c anogate-ros2 -l print-config -d 'print the resulting configuration as a file'
