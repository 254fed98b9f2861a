#include "deploy/scenes/leaf_image.h"

#include <array>
#include <cmath>
#include <string_view>

namespace penumbra::sample {
namespace {

constexpr uint32_t kSide = 128;

using Bytes = std::vector<uint8_t>;

void AddBigEndian(Bytes& out, uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<uint8_t>(value >> shift));
}

// ISO 3309, as PNG has it.
uint32_t Crc32(const uint8_t* data, size_t size) {
  uint32_t crc = 0xffffffffu;
  for (size_t i = 0; i < size; ++i) {
    crc ^= data[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0xedb88320u : 0u);
  }
  return ~crc;
}

uint32_t Adler32(const Bytes& data) {
  uint32_t a = 1, b = 0;
  for (const uint8_t byte : data) {
    a = (a + byte) % 65521;
    b = (b + a) % 65521;
  }
  return b << 16 | a;
}

void AddChunk(Bytes& png, std::string_view type, const Bytes& payload) {
  AddBigEndian(png, static_cast<uint32_t>(payload.size()));
  const size_t begin = png.size();
  png.insert(png.end(), type.begin(), type.end());
  png.insert(png.end(), payload.begin(), payload.end());
  AddBigEndian(png, Crc32(png.data() + begin, png.size() - begin));
}

// A zlib stream of one stored block: the same bytes whatever the compressor's version.
Bytes Stored(const Bytes& raw) {
  const auto size = static_cast<uint16_t>(raw.size());
  Bytes out = {0x78,
               0x01,
               0x01,
               static_cast<uint8_t>(size),
               static_cast<uint8_t>(size >> 8),
               static_cast<uint8_t>(~size),
               static_cast<uint8_t>(~size >> 8)};
  out.insert(out.end(), raw.begin(), raw.end());
  AddBigEndian(out, Adler32(raw));
  return out;
}

// Whether the frond covers (x, y) in [−1, 1] × [0, 1], y upwards: a stem, and pairs of leaflets
// that lean outwards and shorten towards the tip.
bool IsLeaf(double x, double y) {
  x = std::abs(x);
  if (x < 0.035 * (1.1 - y)) return true;
  for (int pair = 0; pair < 7; ++pair) {
    const double foot = 0.10 + 0.115 * pair;
    const double length = 0.86 - 0.09 * pair;
    // Along a direction of 3 : 4 upwards, in units of the leaflet's half-axes.
    const double along = (0.8 * x + 0.6 * 2.0 * (y - foot)) / length - 0.5;
    const double across = (0.8 * 2.0 * (y - foot) - 0.6 * x) / 0.2;
    if (4.0 * along * along + 4.0 * across * across < 1.0) return true;
  }
  return false;
}

}  // namespace

std::vector<uint8_t> LeafPng() {
  Bytes raw;  // a filter type of 0 before each row, one palette entry a byte
  for (uint32_t j = 0; j < kSide; ++j) {
    raw.push_back(0);
    for (uint32_t i = 0; i < kSide; ++i) {
      const double x = (2.0 * i + 1.0) / kSide - 1.0;
      const double y = 1.0 - (j + 0.5) / kSide;
      raw.push_back(IsLeaf(x, y) ? 1 : 0);
    }
  }
  Bytes header;
  AddBigEndian(header, kSide);
  AddBigEndian(header, kSide);
  header.insert(header.end(), {8, 3, 0, 0, 0});  // 8 bits of palette, nothing interlaced
  Bytes png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  AddChunk(png, "IHDR", header);
  AddChunk(png, "PLTE", {86, 128, 70, 86, 128, 70});
  AddChunk(png, "tRNS", {0, 255});
  AddChunk(png, "IDAT", Stored(raw));
  AddChunk(png, "IEND", {});
  return png;
}

}  // namespace penumbra::sample
