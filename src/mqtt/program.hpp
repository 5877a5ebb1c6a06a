// The program anogate-mqtt.
#pragma once
namespace anogate {

/// Does not return once it has connected to a broker: the thread that does may hang in the resolver.
int run_mqtt(int argc, char** argv);

}    // namespace anogate
