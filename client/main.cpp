#include "client/command_line.hpp"

int main(int argc, char** argv) {
  dccast::client::commands::Program program;
  dccast::client::interrupt_by_signals(program.interruption);
  return dccast::client::run_command_line({argv + 1, argv + argc}, program);
}
