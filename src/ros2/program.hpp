// The program anogate-ros2.
#pragma once
namespace anogate {

/// Does not return if the program joined a network: threads of the DDS library may hang at exit.
int run_ros2(int argc, char** argv);

}    // namespace anogate
