#include <mqtt/fleet_acl.hpp>

namespace anogate {

std::string fleet_acl() {
    return R"(# Access rules for mosquitto (acl_file in mosquitto.conf). The user name of each gateway is its name in topics; with
# "require_certificate true" and "use_identity_as_username true", it is the common name (CN) of its certificate.
# mosquitto grants a subscription to other topics, but delivers nothing. A gateway's messages for other topics are refused (0x87).

# Every gateway: only its own topics.
pattern write anogate/v1/%u/status
pattern write anogate/v1/%u/up/+/+
pattern write anogate/v1/%u/raw/up
pattern write anogate/v1/%u/backlog/+
pattern write anogate/v1/%u/response/#
pattern read anogate/v1/%u/request/+
pattern read anogate/v1/%u/raw/down

# The reader, anogate-mqtt --collect: it receives everything and sends nothing.
user collect
topic read anogate/v1/+/status
topic read anogate/v1/+/up/+/+
topic read anogate/v1/+/backlog/+

# A person or program that sends requests; repeat it for each, with its own name. "allow" in mqtt.json of each gateway lists what it accepts.
user shore
topic read anogate/v1/+/status
topic read anogate/v1/+/up/+/+
topic write anogate/v1/+/request/shore
topic read anogate/v1/+/response/shore
topic read anogate/v1/+/response/shore/+
)";
}

}    // namespace anogate
