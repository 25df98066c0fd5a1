#include "tests/program/program_run.hpp"

const char* ballservo::test::program_path() { return BALLSERVO_PROGRAM; }
