// The scene helpers of tests/physics, compiled into this program too: every folder of tests is a program of its own.
#include "tests/physics/physics_support.cpp"
