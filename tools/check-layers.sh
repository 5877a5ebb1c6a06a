#!/bin/bash
# Each folder includes only what its row names, so that no circle can come into being; and each foreign library is known to few files.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
bad=0

# A folder of include, src or tools, and which of ours it may include.
protocol="ano"
decisions="$protocol gateway"
formats="$protocol ano_json ros gateway record"
wires="$formats sys config world device link"
engine="$protocol ano_json host devices"
rooms="$wires $engine http managed log"
layers=(
    "ano:"
    "device: $protocol"
    "host: $protocol"
    "world: $protocol device"
    "gateway: $protocol"
    "managed: $decisions ano_json device"
    "ano_json: $protocol"
    "ros: $protocol ano_json"
    "record: $decisions ano_json ros"
    "sys: $protocol"
    "config: $decisions ano_json sys"
    "link: $decisions config record sys world"
    "http: $protocol ano_json sys"
    "devices: $protocol ano_json host http"
    "log: $decisions ano_json sys"
    "gpio: $decisions ano_json config http link log sys"
    "runtime: $rooms gpio"
    "watch: $rooms runtime"
    "status: $rooms gpio runtime"
    "recording: $rooms runtime watch"
    "foxglove: $rooms runtime watch"
    "control: $rooms gpio runtime watch status recording foxglove"
    "daemon: $rooms gpio runtime watch status recording foxglove control"
    "client: $protocol ano_json gateway http record ros sys"
    "ros2: $protocol ano_json client config gateway http log record ros sys"
    "mavlink: $decisions ano_json client config host http link log record ros sys"
    "mqtt: $protocol ano_json client config gateway http log record ros sys"
    "anoctl: $wires $engine http"
    "reference: $rooms daemon anoctl ros2 mavlink mqtt"
)
names=$(printf '%s\n' "${layers[@]%%:*}" | paste -sd'|')
for layer in "${layers[@]}"; do
    folder=${layer%%:*}
    others="$folder ${layer#*:}"
    paths=()
    for path in include/$folder src/$folder tools/$folder; do if [[ -d $path ]]; then paths+=("$path"); fi; done
    others=$(tr -s ' ' '|' <<<"${others% }")
    if grep -rnE "^ *# *include *[<\"]($names)/" "${paths[@]}" --include='*.?pp' | grep -vE "include *[<\"](${others%|})/"; then bad=1; fi
done
for path in include/*/ src/*/ tools/*/; do
    folder=$(basename "$path")
    if compgen -G "$path*.cpp" >/dev/null && ! [[ $folder =~ ^($names)$ ]]; then echo "$path has no row in tools/check-layers.sh"; bad=1; fi
done

# forbid PATTERN PATH...: no #include there may match.
forbid() {
    local pattern=$1
    shift
    if grep -rnE "^ *# *include *[<\"]($pattern)" "$@"; then bad=1; fi
}
third_party='boost/|spdlog/|nlohmann/|CLI/|gpiod'
system='sys/[a-z]+\.h[>"]|netinet/|arpa/|net/|linux/|termios|unistd|fcntl'
forbid "$third_party|$system" include/ano src/ano include/device src/device include/host src/host
forbid "boost/|spdlog/|CLI/|gpiod|$system" src/world src/ano_json src/ros src/record src/config src/devices src/managed
forbid "boost/|spdlog/|CLI/|gpiod|termios|fcntl" include/gateway src/gateway
forbid "CLI/|spdlog/" src/link src/sys tools/anoctl/*.hpp tools/anoctl/*/*.hpp
forbid "nlohmann/|CLI/|spdlog/" src/http
forbid "boost/beast" --include='*.hpp' src/http

# no_more_of FOLDER PATTERN: of src/http, that folder includes nothing else.
no_more_of() {
    if grep -rnE '^ *# *include *[<"]http/' "$1" | grep -vE "<http/($2)\.hpp>"; then bad=1; fi
}
no_more_of src/devices 'client_text|large_body|places|producer|request|response|routes|web_socket'
no_more_of tools/anoctl 'answer|asio|client/certificate|client/client|client/percent_encoded|producer|request|response|routes|socket_path|web_socket'    # the client's side
no_more_of src/client 'answer|client/client|client/percent_encoded|request|socket_path|web_socket'
no_more_of src/ros2 'answer|client/percent_encoded'
no_more_of src/mavlink 'answer|client/percent_encoded'
no_more_of src/mqtt 'answer'
no_more_of src/gpio 'response'

# only_in FILES INCLUDE: no other file has such an #include; FILES is a pattern.
only_in() {
    if grep -rlE "^ *# *include *<($2)" include src tools tests --include='*.?pp' | grep -vxE "$1"; then bad=1; fi
}
forbid "sys/asio\.hpp" src/link/*.hpp src/link/*/*.hpp    # asio_fwd.hpp: otherwise everybody who knows a link would compile it
only_in 'src/(sys|http)/asio(_ssl)?\.hpp' 'boost/asio'
only_in 'src/(http/(tls|client/certificate)|link/tcp/tls_context|sys/certificate_validity|ros2/type_hash|mavlink/signature|mqtt/broker)\.cpp|tests/support/(key_updates|changed_certificate)\.hpp' 'openssl/|http/asio_ssl'
only_in 'src/http/[a-z_/]+\.cpp' 'boost/beast'
only_in 'src/gpio/gpio_line\.cpp' 'gpiod'
only_in 'tools/anoctl/device/png\.cpp|tests/.*' 'png\.h'
only_in 'tools/anoctl/web/qr_text\.cpp' 'qrencode\.h'
only_in 'src/record/zstd\.cpp' 'zstd\.h'
only_in 'src/ros2/fast_dds\.cpp|tests/ros2/.*' 'fast(dds|rtps)/'
only_in 'src/mqtt/broker\.cpp|tests/mqtt/.*' '(mosquitto|mqtt_protocol)\.h'
only_in 'src/mqtt/spool\.cpp|tests/mqtt/.*' 'sqlite3\.h'
only_in 'src/(daemon|ros2|mavlink|mqtt)/command_line\.cpp|tools/anoctl/anoctl\.cpp' 'CLI/'
only_in '(src|tools)/[a-z0-9_/]+\.cpp|src/config/key_objects\.hpp|tests/.*' 'nlohmann/json\.hpp'
only_in 'src/log/log(_line|_queue|_writer)?\.[ch]pp|tests/.*' 'spdlog/'
((bad == 0)) || echo "These includes violate the layers."
if grep -rnE '\bkind(->name|\.name|\(\))? *(==|!=) *"|"[a-z-]+" *(==|!=) *[a-z_.>()-]*\bkind\b' src include tools --include='*.?pp'; then
    echo "A kind of link is not asked for its name: what is different of it stands in its row (src/config/link_kind.hpp)."
    bad=1
fi
exit "$bad"
