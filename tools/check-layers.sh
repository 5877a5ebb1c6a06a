#!/bin/bash
# Each layer includes only what stands before it: ano < gateway < config < link < http < daemon; ano < host < devices < daemon; and ano < device < world < link;
# gateway and device < managed < daemon; ano_json < ros < record; gateway < record < link.
# Two headers of ours include Asio, one source libgpiod, one libpng, one zstd, sources of src/http alone Beast, two of them OpenSSL, one source of each
# program CLI11, no header all of nlohmann's JSON, spdlog the sources of the log alone. What a kind of link is called is known to its own file alone.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
bad=0

# forbid PATTERN PATH...: no #include there may match.
forbid() {
    local pattern=$1
    shift
    if grep -rnE "^ *# *include *[<\"]($pattern)" "$@"; then bad=1; fi
}
third_party='boost/|spdlog/|nlohmann/|CLI/|gpiod'
system='sys/|netinet/|arpa/|net/|linux/|termios|unistd|fcntl'
forbid "gateway/|device/|world/|host/|config/|link/|http/|daemon/|$third_party|$system" include/ano src/ano
forbid "gateway/|world/|host/|config/|link/|http/|daemon/|$third_party|$system" include/device src/device
forbid "gateway/|device/|world/|config/|link/|http/|daemon/|$third_party|$system" include/host src/host
forbid "gateway/|host/|config/|link/|http/|daemon/|$third_party|$system" src/world
forbid "gateway/|link/|http/|daemon/|boost/|spdlog/|CLI/|gpiod|$system" src/ano_json
forbid "device/|world/|host/|config/|link/|http/|daemon/|boost/|spdlog/|CLI/|gpiod|termios|fcntl" include/gateway src/gateway
forbid "device/|world/|host/|config/|link/|http/|daemon/|boost/|spdlog/|CLI/|gpiod|$system" src/record
forbid "gateway/|record/|device/|world/|host/|config/|link/|http/|daemon/|boost/|spdlog/|CLI/|gpiod|$system" src/ros
forbid "world/|link/|http/|daemon/|boost/|spdlog/|CLI/|gpiod|$system" src/config
forbid "gateway/|world/|config/|link/|daemon/|boost/|spdlog/|CLI/|gpiod|$system" src/devices
if grep -rnE '^ *# *include *[<"]http/' src/devices | grep -vE '<http/(large_body|producer|request|response|routes|web_socket)\.hpp>'; then bad=1; fi
forbid "world/|host/|config/|link/|http/|daemon/|devices/|boost/|spdlog/|CLI/|gpiod|$system" src/managed
forbid "managed/" include src/ano src/device src/world src/host src/gateway src/ano_json src/config src/link src/http src/devices tools
forbid "devices/" include src/ano src/device src/world src/host src/gateway src/ano_json src/config src/link src/http
forbid "daemon/|spdlog/" tools/anoctl
# Of the door, only the client's side; and the table of routes, for the devices at a link of its own.
if grep -rnE '^ *# *include *[<"]http/' tools/anoctl | grep -vE '<http/(answer|asio|certificate|client|producer|request|response|routes|socket_path|web_socket)\.hpp>'; then bad=1; fi
forbid "http/|daemon/|spdlog/|CLI/" src/link
forbid "gateway/|config/|daemon/|spdlog/|nlohmann/|CLI/" src/http
forbid "boost/beast" --include='*.hpp' src/http

# only_in FILES INCLUDE: no other file has such an #include; FILES is a pattern.
only_in() {
    if grep -rlE "^ *# *include *<($2)" include src tools tests --include='*.?pp' | grep -vxE "$1"; then bad=1; fi
}
forbid "link/asio\.hpp" src/link/*.hpp    # asio_fwd.hpp: otherwise everybody who knows a link would compile it
only_in 'src/(link|http)/asio(_ssl)?\.hpp' 'boost/asio'
only_in 'src/http/(tls|certificate)\.cpp' 'openssl/|http/asio_ssl'
only_in 'src/http/[a-z_]+\.cpp' 'boost/beast'
only_in 'src/link/gpio_line\.cpp' 'gpiod'
only_in 'tools/anoctl/device/png\.cpp|tests/.*' 'png\.h'
only_in 'src/record/zstd\.cpp' 'zstd\.h'
only_in 'src/daemon/command_line\.cpp|tools/anoctl/anoctl\.cpp' 'CLI/'
only_in '(src|tools)/[a-z_/]+\.cpp|tests/.*' 'nlohmann/json\.hpp'
only_in 'src/daemon/log(_line|_queue|_writer)?\.[ch]pp|tests/.*' 'spdlog/'
((bad == 0)) || echo "These includes reach over a layer."
if grep -rnE '\bkind(->name|\.name|\(\))? *(==|!=) *"|"[a-z-]+" *(==|!=) *[a-z_.>()-]*\bkind\b' src include tools --include='*.?pp'; then
    echo "A kind of link is not asked for its name: what is different of it stands in its row (src/config/link_kind.hpp)."
    bad=1
fi
exit "$bad"
