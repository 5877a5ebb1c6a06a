# Completions of bash for anoctl. Generated from its tables of options and commands.
_anoctl_words() { COMPREPLY=($(compgen -W "$1" -- "$cur")); }
_anoctl_files() { compopt -o filenames 2>/dev/null; COMPREPLY=($(compgen -f -- "$cur")); }
_anoctl_ports() { COMPREPLY=($(compgen -G "${cur:-/dev/}*" | grep -E '^/dev/(tty(USB|ACM|AMA|S)|serial|rfcomm)')); }
_anoctl_messages() { COMPREPLY=($(compgen -W 'altitude attitude_control check command command_info command_query compass device_info euler firmware flexible1 flexible10 flexible2 flexible3 flexible4 flexible5 flexible6 flexible7 flexible8 flexible9 general_position general_velocity gps image image_feature inertial ip_tunnel ip_tunnel_short log log_value mode module_status optical_flow parameter_command parameter_info parameter_value position power pwm quaternion ranging raw_flow realtime_control remote_control return_home rgb special target_attitude target_velocity velocity waypoint waypoint_read wind' -- "$cur")); }
# A colon ends a word of bash: behind one, the address of the link.
_anoctl_links() {
    local kind=$cur
    if [[ $cur == *:* ]]; then
        kind=${cur%%:*} cur=${cur#*:}
    elif [[ $prev == : ]]; then
        kind=${COMP_WORDS[COMP_CWORD - 2]}
    elif [[ $cur == : ]]; then
        kind=$prev cur=
    else
        compopt -o nospace 2>/dev/null
        _anoctl_words 'serial: hid: udp-listen: udp: tcp: tcp-listen: tls: tls-listen: can: pty: sim: replay:'
        return
    fi
    case $kind in
        serial) _anoctl_ports ;;
        pty) _anoctl_files ;;
        can) COMPREPLY=($(compgen -W "$(ls /sys/class/net 2>/dev/null | grep can)" -- "$cur")) ;;
    esac
}
_anoctl_known() { "${COMP_WORDS[0]}" __complete "$1" "${COMP_WORDS[@]:1}" 2>/dev/null | cut -f1; }
_anoctl_addresses() { _anoctl_words "power_unit ros_2_bridge vendor_mcu flight_controller imu optical_flow openmv_camera data_radio protocol_simulator host broadcast $(_anoctl_known devices)"; }
_anoctl_link_names() { _anoctl_words "$(_anoctl_known links)"; }
# A message, then its fields. '=' is a word of bash.
_anoctl_fields() {
    local known
    known=$("${COMP_WORDS[0]}" __complete fields "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null) || { _anoctl_messages; return; }
    if [[ $cur == = ]]; then cur=; fi
    if [[ $known == *= ]]; then compopt -o nospace 2>/dev/null; fi
    _anoctl_words "$known"
}
_anoctl_devices() { _anoctl_words "$(_anoctl_known names)"; }
_anoctl_commands() { _anoctl_words "$(_anoctl_known commands)"; }
_anoctl_parameters() {
    case ${COMP_WORDS[2]} in
        get | set) _anoctl_words "$(_anoctl_known parameters)" ;;
        *) _anoctl_files ;;
    esac
}
_anoctl() {
    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]} command= options= operands=:
    COMPREPLY=()
    if ((COMP_CWORD == 1)); then _anoctl_words 'decode encode messages monitor ports setup status links routes metrics reload flexible send devices param command waypoint flash calibrate log alarms image terminal top record recordings info convert replay plot-udp web certificate help --help --version'; return; fi
    command=${COMP_WORDS[1]}
    if [[ $command == help ]]; then _anoctl_words 'decode encode messages monitor ports setup status links routes metrics reload flexible send devices param command waypoint flash calibrate log alarms image terminal top record recordings info convert replay plot-udp web certificate'; return; fi
    case "$command $prev" in
        'decode --encoding') _anoctl_words 'utf8 gbk'; return ;;
        'decode --value-type-7') _anoctl_words 'f32 u64'; return ;;
        'decode --config') _anoctl_files; return ;;
        'encode --from') _anoctl_addresses; return ;;
        'encode --to') _anoctl_addresses; return ;;
        'encode --data') :; return ;;
        'encode --encoding') _anoctl_words 'utf8 gbk'; return ;;
        'encode --value-type-7') _anoctl_words 'f32 u64'; return ;;
        'encode --config') _anoctl_files; return ;;
        'messages --config') _anoctl_files; return ;;
        'monitor --id') _anoctl_messages; return ;;
        'monitor --from') _anoctl_addresses; return ;;
        'monitor --to') _anoctl_addresses; return ;;
        'monitor --link') _anoctl_link_names; return ;;
        'monitor --direction') _anoctl_words 'in out dropped'; return ;;
        'monitor --count') :; return ;;
        'monitor --control') _anoctl_files; return ;;
        'monitor --encoding') _anoctl_words 'utf8 gbk'; return ;;
        'monitor --value-type-7') _anoctl_words 'f32 u64'; return ;;
        'monitor --config') _anoctl_files; return ;;
        'ports --detect') _anoctl_ports; return ;;
        'setup --baud') :; return ;;
        'setup --into') _anoctl_files; return ;;
        'setup --control') _anoctl_files; return ;;
        'status --control') _anoctl_files; return ;;
        'links --control') _anoctl_files; return ;;
        'routes --forget') _anoctl_addresses; return ;;
        'routes --control') _anoctl_files; return ;;
        'metrics --control') _anoctl_files; return ;;
        'reload --confirm-within') :; return ;;
        'reload --control') _anoctl_files; return ;;
        'flexible --control') _anoctl_files; return ;;
        'send --from') _anoctl_addresses; return ;;
        'send --to') _anoctl_addresses; return ;;
        'send --data') :; return ;;
        'send --control') _anoctl_files; return ;;
        'send --encoding') _anoctl_words 'utf8 gbk'; return ;;
        'send --value-type-7') _anoctl_words 'f32 u64'; return ;;
        'send --config') _anoctl_files; return ;;
        'devices --cancel') :; return ;;
        'devices --link') _anoctl_links; return ;;
        'devices --control') _anoctl_files; return ;;
        'param --device') _anoctl_devices; return ;;
        'param --link') _anoctl_links; return ;;
        'param --control') _anoctl_files; return ;;
        'command --cid') :; return ;;
        'command --type7') _anoctl_words 'f32 u64'; return ;;
        'command --device') _anoctl_devices; return ;;
        'command --link') _anoctl_links; return ;;
        'command --control') _anoctl_files; return ;;
        'waypoint --format') _anoctl_words 'json geojson qgc'; return ;;
        'waypoint --device') _anoctl_devices; return ;;
        'waypoint --link') _anoctl_links; return ;;
        'waypoint --control') _anoctl_files; return ;;
        'flash --crc') _anoctl_words 'ibm-3740 xmodem kermit modbus arc'; return ;;
        'flash --device') _anoctl_devices; return ;;
        'flash --link') _anoctl_links; return ;;
        'flash --control') _anoctl_files; return ;;
        'calibrate --device') _anoctl_devices; return ;;
        'calibrate --link') _anoctl_links; return ;;
        'calibrate --control') _anoctl_files; return ;;
        'log --device') _anoctl_devices; return ;;
        'log --link') _anoctl_links; return ;;
        'log --control') _anoctl_files; return ;;
        'log --encoding') _anoctl_words 'utf8 gbk'; return ;;
        'log --since') :; return ;;
        'alarms --device') _anoctl_devices; return ;;
        'alarms --control') _anoctl_files; return ;;
        'image --count') :; return ;;
        'image --device') _anoctl_devices; return ;;
        'image --link') _anoctl_links; return ;;
        'image --control') _anoctl_files; return ;;
        'terminal --pcapng') _anoctl_files; return ;;
        'terminal --encoding') _anoctl_words 'utf8 gbk'; return ;;
        'terminal --end') _anoctl_words 'crlf lf cr none'; return ;;
        'terminal --control') _anoctl_files; return ;;
        'top --control') _anoctl_files; return ;;
        'record --id') _anoctl_messages; return ;;
        'record --from') _anoctl_addresses; return ;;
        'record --to') _anoctl_addresses; return ;;
        'record --link') _anoctl_link_names; return ;;
        'record --direction') _anoctl_words 'in out dropped'; return ;;
        'record --seconds') :; return ;;
        'record --message-encoding') _anoctl_words 'cdr json'; return ;;
        'record --control') _anoctl_files; return ;;
        'recordings --format') _anoctl_words 'pcapng mcap'; return ;;
        'recordings --message-encoding') _anoctl_words 'cdr json'; return ;;
        'recordings --id') _anoctl_messages; return ;;
        'recordings --from') _anoctl_addresses; return ;;
        'recordings --to') _anoctl_addresses; return ;;
        'recordings --link') _anoctl_link_names; return ;;
        'recordings --direction') _anoctl_words 'in out dropped'; return ;;
        'recordings --seconds') :; return ;;
        'recordings --control') _anoctl_files; return ;;
        'convert --id') _anoctl_messages; return ;;
        'convert --message-encoding') _anoctl_words 'cdr json'; return ;;
        'convert --encoding') _anoctl_words 'utf8 gbk'; return ;;
        'convert --value-type-7') _anoctl_words 'f32 u64'; return ;;
        'convert --config') _anoctl_files; return ;;
        'replay --rate') :; return ;;
        'plot-udp --id') _anoctl_messages; return ;;
        'plot-udp --from') _anoctl_addresses; return ;;
        'plot-udp --to') _anoctl_addresses; return ;;
        'plot-udp --link') _anoctl_link_names; return ;;
        'plot-udp --direction') _anoctl_words 'in out dropped'; return ;;
        'plot-udp --control') _anoctl_files; return ;;
        'plot-udp --encoding') _anoctl_words 'utf8 gbk'; return ;;
        'plot-udp --config') _anoctl_files; return ;;
        'web --control') _anoctl_files; return ;;
        'certificate --into') :; return ;;
    esac
    case $command in
        'decode') options='--v7 --json --encoding --value-type-7 --config -h --help'; operands='_anoctl_files' ;;
        'encode') options='--from --to --data --raw --v7 --json --encoding --value-type-7 --config -h --help'; operands='_anoctl_fields' ;;
        'messages') options='--markdown --json --lua --config -h --help'; operands='_anoctl_messages' ;;
        'monitor') options='--id --from --to --link --direction --count --control --json --encoding --value-type-7 --config -h --help'; operands='_anoctl_links' ;;
        'ports') options='--detect --json -h --help'; operands=':' ;;
        'setup') options='--baud --into --control --yes -h --help'; operands='_anoctl_ports' ;;
        'status') options='--control --exit-code --json -h --help'; operands=':' ;;
        'links') options='--control --json -h --help'; operands='_anoctl_link_names' ;;
        'routes') options='--forget --control --json -h --help'; operands=':' ;;
        'metrics') options='--control --openmetrics --json -h --help'; operands=':' ;;
        'reload') options='--dry-run --confirm-within --confirm --control --json -h --help'; operands=':' ;;
        'flexible') options='--json --control -h --help'; operands='if ((COMP_CWORD == 2)); then _anoctl_words '\''list set'\''; else _anoctl_files; fi' ;;
        'send') options='--from --to --data --control --json --encoding --value-type-7 --config -h --help'; operands='_anoctl_fields' ;;
        'devices') options='--scan --jobs --cancel --link --control --json --yes -h --help'; operands=':' ;;
        'param') options='--all --with-calibration --longer --force --rollback --device --link --control --json --yes -h --help'; operands='if ((COMP_CWORD == 2)); then _anoctl_words '\''list get set save reset export import diff'\''; else _anoctl_parameters; fi' ;;
        'command') options='--cid --repeat --type7 --device --link --control --json --yes -h --help'; operands='if ((COMP_CWORD == 2)); then _anoctl_words '\''list call'\''; else _anoctl_commands; fi' ;;
        'waypoint') options='--format --device --link --control --json --yes -h --help'; operands='if ((COMP_CWORD == 2)); then _anoctl_words '\''get put'\''; else _anoctl_files; fi' ;;
        'flash') options='--force --crc --device --link --control --json --yes -h --help'; operands='_anoctl_files' ;;
        'calibrate') options='--device --link --control --json --yes -h --help'; operands='_anoctl_words '\''accelerometer compass'\''' ;;
        'log') options='--device --link --control --encoding --since --no-follow --json -h --help'; operands=':' ;;
        'alarms') options='--follow --device --control --json -h --help'; operands=':' ;;
        'image') options='--count --device --link --control --json -h --help'; operands='_anoctl_files' ;;
        'terminal') options='--hex --v7 --pcapng --force --encoding --end --exclusive --json --control -h --help'; operands='_anoctl_links' ;;
        'top') options='--control -h --help'; operands=':' ;;
        'record') options='--id --from --to --link --direction --seconds --last --message-encoding --force --json --control -h --help'; operands='_anoctl_files' ;;
        'recordings') options='--format --message-encoding --id --from --to --link --direction --seconds --force --json --control -h --help'; operands='if ((COMP_CWORD == 2)); then _anoctl_words '\''list start end get delete save'\''; else _anoctl_messages; fi' ;;
        'info') options='--all --json -h --help'; operands='_anoctl_files' ;;
        'convert') options='--id --message-encoding --force --json --encoding --value-type-7 --config -h --help'; operands='_anoctl_files' ;;
        'replay') options='--commands --rate --json -h --help'; operands='_anoctl_files' ;;
        'plot-udp') options='--id --from --to --link --direction --control --encoding --config -h --help'; operands='_anoctl_links' ;;
        'web') options='--open --qr --pair --view --control --json -h --help'; operands=':' ;;
        'certificate') options='--into --renew --json -h --help'; operands=':' ;;
    esac
    if [[ $cur == -* ]]; then _anoctl_words "$options"; else eval "$operands"; fi
}
complete -F _anoctl anoctl
