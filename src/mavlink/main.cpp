#include <mavlink/program.hpp>

int main(int argc, char** argv) { return anogate::run_mavlink(argc, argv); }
