#include "model_octets.hpp"

#include <algorithm>
#include <string_view>

#include "base/crc.hpp"

namespace polhode::platform {
namespace {

constexpr std::string_view kMagic = "PLHMODEL";
constexpr std::size_t kNumberBytes = 8;
static_assert(kModelHeadOctets == kMagic.size() + 2 * kNumberBytes);  // octets, CRC-32

void put_number(std::uint64_t number, std::uint8_t* out) {
  for (std::size_t i = 0; i < kNumberBytes; ++i) {
    out[i] = static_cast<std::uint8_t>(number >> 8 * i);
  }
}

std::uint64_t number_at(const std::uint8_t* octets) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < kNumberBytes; ++i) {
    number |= std::uint64_t{octets[i]} << 8 * i;
  }
  return number;
}

}  // namespace

std::size_t model_octets_max() { return kModelHeadOctets + target_model_octets_max(); }

bool begins_as_model(std::span<const std::uint8_t> octets) {
  return octets.size() >= kModelHeadOctets &&
         std::equal(kMagic.begin(), kMagic.end(), octets.begin());
}

std::size_t save_model_octets(const Component& component, std::span<std::uint8_t> out) {
  const std::size_t octets = save_target_model(component, out.subspan(kModelHeadOctets));
  if (octets == 0) {
    return 0;
  }
  std::copy(kMagic.begin(), kMagic.end(), out.begin());
  put_number(octets, &out[kMagic.size()]);
  put_number(crc32_iso_hdlc(out.subspan(kModelHeadOctets, octets)),
             &out[kMagic.size() + kNumberBytes]);
  return kModelHeadOctets + octets;
}

std::string load_model_octets(std::span<const std::uint8_t> octets,
                              Component* component,
                              TargetModelFacts* facts) {
  if (!begins_as_model(octets)) {
    return "no model of a target";
  }
  if (octets.size() > model_octets_max()) {
    return "larger than this program's tables";
  }
  const std::span<const std::uint8_t> content = octets.subspan(kModelHeadOctets);
  if (number_at(&octets[kMagic.size()]) != content.size() ||
      number_at(&octets[kMagic.size() + kNumberBytes]) != crc32_iso_hdlc(content)) {
    return "cut off or damaged";
  }
  const Result<TargetModelFacts> loaded = load_target_model(content, component);
  if (!loaded) {
    return loaded.error().message;
  }
  *facts = loaded.value();
  return "";
}

}  // namespace polhode::platform
