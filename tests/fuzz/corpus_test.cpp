// The fuzz target on its fixed corpus and on a million mutations of it, every day.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "base/rng.hpp"
#include "fuzz_counts.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace polhode::corpus_test {
namespace {

using Octets = std::vector<std::uint8_t>;

std::vector<Octets> corpus() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(POLHODE_CORPUS)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<Octets> all;
  for (const auto& file : files) {
    std::ifstream in(file, std::ios::binary);
    all.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  return all;
}

void mutate(Rng& rng, Octets* octets) {
  const auto size = static_cast<std::uint32_t>(octets->size());
  switch (rng.below(4)) {
    case 0:  // cut or lengthened
      octets->resize(rng.below(2 * size + 2));
      break;
    case 1:  // one bit
      if (size > 0) (*octets)[rng.below(size)] ^= static_cast<std::uint8_t>(1U << rng.below(8));
      break;
    case 2:  // some octets
      for (std::uint32_t i = 0; i < 4 && size > 0; ++i)
        (*octets)[rng.below(size)] = static_cast<std::uint8_t>(rng.below(256));
      break;
    default:  // noise altogether
      for (std::uint8_t& octet : *octets) octet = static_cast<std::uint8_t>(rng.below(256));
      break;
  }
}

TEST(FuzzCorpus, IsReadWithoutHarm) {
  const auto all = corpus();
  ASSERT_GE(all.size(), 20U);
  const std::uint64_t taken_before = fuzz::counts().taken;
  for (const Octets& octets : all) {
    EXPECT_EQ(LLVMFuzzerTestOneInput(octets.data(), octets.size()), 0);
  }
  EXPECT_GE(fuzz::counts().taken - taken_before, 13U);  // one good command of each code
}

// verifies: CMD-02
TEST(FuzzCorpus, AMillionMutationsAreEachTakenOrRefused) {
  const auto all = corpus();
  const fuzz::Counts before = fuzz::counts();
  Rng rng(2024, 1);
  constexpr std::uint64_t kPackets = 1'000'000;
  for (std::uint64_t i = 0; i < kPackets; ++i) {
    Octets octets = all[rng.below(static_cast<std::uint32_t>(all.size()))];
    mutate(rng, &octets);
    LLVMFuzzerTestOneInput(octets.data(), octets.size());
  }
  const fuzz::Counts& after = fuzz::counts();
  EXPECT_GE(after.given - before.given, kPackets);
  EXPECT_EQ(after.taken + after.refused_in_all(), after.given);
  for (const std::size_t reason : {1, 2, 3, 4, 5}) {  // LENGTH, HEADER, CRC, UNKNOWN_CODE, RANGE
    EXPECT_GT(after.refused[reason], before.refused[reason]) << reason;
  }
}

}  // namespace
}  // namespace polhode::corpus_test
