#include <daemon/program.hpp>

int main(int argc, char** argv) { return anogate::run_program(argc, argv); }
