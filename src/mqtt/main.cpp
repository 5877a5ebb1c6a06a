#include <mqtt/program.hpp>

int main(int argc, char** argv) { return anogate::run_mqtt(argc, argv); }
