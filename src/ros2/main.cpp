#include <ros2/program.hpp>

int main(int argc, char** argv) { return anogate::run_ros2(argc, argv); }
