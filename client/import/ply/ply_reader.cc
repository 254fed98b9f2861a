#include "client/import/ply/ply_reader.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "client/import/source_file.h"

namespace penumbra::ply {
namespace {

template <typename T>
double As(const std::array<std::byte, 8>& little_endian) {
  T value;
  std::memcpy(&value, little_endian.data(), sizeof(T));
  return static_cast<double>(value);
}

double Load(const std::array<std::byte, 8>& bytes, Scalar type) {
  switch (type) {
    case Scalar::kInt8:
      return As<int8_t>(bytes);
    case Scalar::kUint8:
      return As<uint8_t>(bytes);
    case Scalar::kInt16:
      return As<int16_t>(bytes);
    case Scalar::kUint16:
      return As<uint16_t>(bytes);
    case Scalar::kInt32:
      return As<int32_t>(bytes);
    case Scalar::kUint32:
      return As<uint32_t>(bytes);
    case Scalar::kFloat:
      return As<float>(bytes);
    case Scalar::kDouble:
      return As<double>(bytes);
  }
  return 0.0;
}

template <typename T>
bool Fits(double value) {
  return value == std::floor(value) && value >= double{std::numeric_limits<T>::min()} &&
         value <= double{std::numeric_limits<T>::max()};
}

bool FitsIn(double value, Scalar type) {
  switch (type) {
    case Scalar::kInt8:
      return Fits<int8_t>(value);
    case Scalar::kUint8:
      return Fits<uint8_t>(value);
    case Scalar::kInt16:
      return Fits<int16_t>(value);
    case Scalar::kUint16:
      return Fits<uint16_t>(value);
    case Scalar::kInt32:
      return Fits<int32_t>(value);
    case Scalar::kUint32:
      return Fits<uint32_t>(value);
    default:
      return true;
  }
}

bool IsBlank(std::byte b) {
  return b == std::byte{' '} || b == std::byte{'\t'} || b == std::byte{'\n'} ||
         b == std::byte{'\r'};
}

}  // namespace

std::optional<double> Reader::Next(Scalar type) {
  if (format_ == Format::kAscii) return NextAscii(type);
  const size_t size = BytesOf(type);
  if (rest_.size() < size) return std::nullopt;
  std::array<std::byte, 8> bytes{};
  std::copy_n(rest_.begin(), size, bytes.begin());
  if (format_ == Format::kBinaryBigEndian) std::reverse(bytes.begin(), bytes.begin() + size);
  rest_ = rest_.subspan(size);
  return Load(bytes, type);
}

std::optional<double> Reader::NextAscii(Scalar type) {
  const auto start = std::find_if_not(rest_.begin(), rest_.end(), IsBlank);
  const auto end = std::find_if(start, rest_.end(), IsBlank);
  std::string_view word = AsText({start, end});
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0.0;
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  rest_ = {end, rest_.end()};
  if (word.empty() || stop != word.data() + word.size()) return std::nullopt;
  // A denormal that underflows is 0; a number that overflows is none.
  if (error == std::errc::result_out_of_range && std::abs(value) > 1.0) return std::nullopt;
  if (error == std::errc::invalid_argument || !FitsIn(value, type)) return std::nullopt;
  return value;
}

}  // namespace penumbra::ply
