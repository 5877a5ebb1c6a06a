# Completions of fish for anogated. Generated from its tables of options and commands.
complete -c anogated -f
complete -c anogated -s h -l help -d 'Print this help and exit'
complete -c anogated -s V -l version -d 'print the version'
complete -c anogated -s c -l config -r -F -d 'JSON file'
complete -c anogated -l id -x -d 'the hardware id of the gateway itself '
complete -c anogated -l unknown -x -a 'flood drop' -d 'what to do with frames to unknown addresses'
complete -c anogated -l control -r -F -d 'path of the control socket, or none '
complete -c anogated -l http -x -d 'the same interface over TCP, at this address '
complete -c anogated -l log-level -x -a 'trace debug info warn error' -d 'the lowest level to log'
complete -c anogated -l route -x -d 'pin an address or range '
complete -c anogated -l check -d 'check the configuration'
complete -c anogated -l print-config -d 'print the resulting configuration as a file'
complete -c anogated -a 'serial: hid: udp-listen: udp: tcp: tcp-listen: tls: tls-listen: can: pty: sim: replay:'
