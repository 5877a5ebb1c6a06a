# Completions of bash for anogate-mavlink. Generated from its tables of options and commands.
_anogate-mavlink_words() { COMPREPLY=($(compgen -W "$1" -- "$cur")); }
_anogate-mavlink_files() { compopt -o filenames 2>/dev/null; COMPREPLY=($(compgen -f -- "$cur")); }
_anogate-mavlink_ports() { COMPREPLY=($(compgen -G "${cur:-/dev/}*" | grep -E '^/dev/(tty(USB|ACM|AMA|S)|serial|rfcomm)')); }
_anogate-mavlink_messages() { COMPREPLY=($(compgen -W 'altitude attitude_control check command command_info command_query compass device_info euler firmware flexible1 flexible10 flexible2 flexible3 flexible4 flexible5 flexible6 flexible7 flexible8 flexible9 general_position general_velocity gps image image_feature inertial ip_tunnel ip_tunnel_short log log_value mode module_status optical_flow parameter_command parameter_info parameter_value position power pwm quaternion ranging raw_flow realtime_control remote_control return_home rgb special target_attitude target_velocity velocity waypoint waypoint_read wind' -- "$cur")); }
# A colon ends a word of bash: behind one, the address of the link.
_anogate-mavlink_links() {
    local kind=$cur
    if [[ $cur == *:* ]]; then
        kind=${cur%%:*} cur=${cur#*:}
    elif [[ $prev == : ]]; then
        kind=${COMP_WORDS[COMP_CWORD - 2]}
    elif [[ $cur == : ]]; then
        kind=$prev cur=
    else
        compopt -o nospace 2>/dev/null
        _anogate-mavlink_words 'serial: hid: udp-listen: udp: tcp: tcp-listen: tls: tls-listen: can: pty: sim: replay:'
        return
    fi
    case $kind in
        serial) _anogate-mavlink_ports ;;
        pty) _anogate-mavlink_files ;;
        can) COMPREPLY=($(compgen -W "$(ls /sys/class/net 2>/dev/null | grep can)" -- "$cur")) ;;
    esac
}
_anogate-mavlink() {
    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]} command= options= operands=:
    COMPREPLY=()
    case "$command $prev" in
        ' -c') _anogate-mavlink_files; return ;;
        ' --config') _anogate-mavlink_files; return ;;
        ' --udp') :; return ;;
        ' --udp-listen') :; return ;;
        ' --tcp-listen') :; return ;;
        ' --serial') _anogate-mavlink_devices; return ;;
        ' --device') :; return ;;
        ' --control') _anogate-mavlink_files; return ;;
        ' --baud') :; return ;;
        ' --signing-file') _anogate-mavlink_files; return ;;
        ' --autopilot') _anogate-mavlink_words 'generic px4 ardupilot'; return ;;
    esac
    case $command in
        '') options='-h --help -V --version -c --config --udp --udp-listen --tcp-listen --serial --device --control --baud --signing-file --autopilot --check --print-config'; operands=':' ;;
    esac
    if [[ $cur == -* ]]; then _anogate-mavlink_words "$options"; else eval "$operands"; fi
}
complete -F _anogate-mavlink anogate-mavlink
