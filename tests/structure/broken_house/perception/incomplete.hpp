// For the tests of structure: needs <string> and does not say so.
#pragma once

inline std::string name() { return "incomplete"; }
