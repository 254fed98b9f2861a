// Writes the project's sample scene: penumbra_make_sample FILE.glb
#include <cstdio>
#include <fstream>

#include "deploy/scenes/atelier.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: penumbra_make_sample FILE.glb\n");
    return 2;
  }
  const std::vector<uint8_t> glb = penumbra::sample::AtelierGlb();
  std::ofstream file(argv[1], std::ios::binary);
  file.write(reinterpret_cast<const char*>(glb.data()), static_cast<std::streamsize>(glb.size()));
  file.close();
  if (!file) {
    std::fprintf(stderr, "penumbra_make_sample: cannot write %s\n", argv[1]);
    return 1;
  }
  return 0;
}
