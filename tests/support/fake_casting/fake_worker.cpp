#include "server/worker/main.hpp"

int main(int argc, char** argv) {
  return dccast::worker::main(argc, argv);
}
