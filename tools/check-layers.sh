#!/bin/bash
# Each layer includes only what stands before it: ano < gateway < link < daemon. One header of ours includes Asio, one source libgpiod.
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
forbid "gateway/|link/|daemon/|$third_party|$system" include/ano src/ano
forbid "gateway/|link/|daemon/|boost/|spdlog/|CLI/|gpiod|$system" src/ano_json
forbid "link/|daemon/|boost/|spdlog/|CLI/|gpiod|termios|fcntl" include/gateway src/gateway
forbid "daemon/|spdlog/|CLI/" src/link
forbid "link/asio\.hpp" src/link/*.hpp    # asio_fwd.hpp: or everybody who knows a link would compile it
if grep -rln 'include *<boost/asio' include src tools tests --include='*.?pp' | grep -vx 'src/link/asio.hpp'; then bad=1; fi
if grep -rln 'include *<gpiod' include src tools tests --include='*.?pp' | grep -vx 'src/link/gpio_line.cpp'; then bad=1; fi
((bad == 0)) || echo "These includes reach over a layer."
exit "$bad"
