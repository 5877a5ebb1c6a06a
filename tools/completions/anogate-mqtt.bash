# Completions of bash for anogate-mqtt. Generated from its tables of options and commands.
_anogate-mqtt_words() { COMPREPLY=($(compgen -W "$1" -- "$cur")); }
_anogate-mqtt_files() { compopt -o filenames 2>/dev/null; COMPREPLY=($(compgen -f -- "$cur")); }
_anogate-mqtt_ports() { COMPREPLY=($(compgen -G "${cur:-/dev/}*" | grep -E '^/dev/(tty(USB|ACM|AMA|S)|serial|rfcomm)')); }
_anogate-mqtt_messages() { COMPREPLY=($(compgen -W 'altitude attitude_control check command command_info command_query compass device_info euler firmware flexible1 flexible10 flexible2 flexible3 flexible4 flexible5 flexible6 flexible7 flexible8 flexible9 general_position general_velocity gps image image_feature inertial ip_tunnel ip_tunnel_short log log_value mode module_status optical_flow parameter_command parameter_info parameter_value position power pwm quaternion ranging raw_flow realtime_control remote_control return_home rgb special target_attitude target_velocity velocity waypoint waypoint_read wind' -- "$cur")); }
# A colon ends a word of bash: behind one, the address of the link.
_anogate-mqtt_links() {
    local kind=$cur
    if [[ $cur == *:* ]]; then
        kind=${cur%%:*} cur=${cur#*:}
    elif [[ $prev == : ]]; then
        kind=${COMP_WORDS[COMP_CWORD - 2]}
    elif [[ $cur == : ]]; then
        kind=$prev cur=
    else
        compopt -o nospace 2>/dev/null
        _anogate-mqtt_words 'serial: hid: udp-listen: udp: tcp: tcp-listen: tls: tls-listen: can: pty: sim: replay:'
        return
    fi
    case $kind in
        serial) _anogate-mqtt_ports ;;
        pty) _anogate-mqtt_files ;;
        can) COMPREPLY=($(compgen -W "$(ls /sys/class/net 2>/dev/null | grep can)" -- "$cur")) ;;
    esac
}
_anogate-mqtt() {
    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]} command= options= operands=:
    COMPREPLY=()
    case "$command $prev" in
        ' -c') _anogate-mqtt_files; return ;;
        ' --config') _anogate-mqtt_files; return ;;
        ' --control') _anogate-mqtt_files; return ;;
        ' --broker') :; return ;;
        ' --name') :; return ;;
        ' --username') :; return ;;
        ' --password-file') _anogate-mqtt_files; return ;;
        ' --tls-ca') _anogate-mqtt_files; return ;;
        ' --tls-certificate') _anogate-mqtt_files; return ;;
        ' --tls-key') _anogate-mqtt_files; return ;;
        ' --spool') :; return ;;
        ' --to') :; return ;;
    esac
    case $command in
        '') options='-h --help -V --version -c --config --control --broker --name --username --password-file --tls-ca --tls-certificate --tls-key --spool --collect --to --mcap --check --print-config --print-acl'; operands=':' ;;
    esac
    if [[ $cur == -* ]]; then _anogate-mqtt_words "$options"; else eval "$operands"; fi
}
complete -F _anogate-mqtt anogate-mqtt
