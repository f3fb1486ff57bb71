// The C client on files and streams that are damaged.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "base/rng.hpp"
#include "errors.hpp"
#include "packets.hpp"
#include "tests/bus/motion_packet.hpp"
#include "transport/file/flat_file.hpp"
#include "transport/transports.hpp"

namespace polhode::platform::stream_test {
namespace {

Octets stream_of(std::uint32_t packets) {
  Octets stream;
  for (std::uint32_t i = 0; i < packets; ++i) {
    const Octets packet = motion_packet(i);
    stream.insert(stream.end(), packet.begin(), packet.end());
  }
  return stream;
}

std::string written(const Folder& folder, const Octets& stream) {
  const std::string file = folder / "bus.ccsds";
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(stream.data()),
            static_cast<std::streamsize>(stream.size()));
  return "file:" + file;
}

std::uint32_t read_all(Reader& reader) {
  std::uint32_t count = 0;
  while (!reader.next().empty()) {
    ++count;
  }
  return count;
}

TEST(FlatFile, HoldsWhatWasSent_AndIsAppendedTo) {
  const Folder folder;
  const std::string address = "file:" + folder / "flight.ccsds";
  for (std::uint32_t run = 0; run < 2; ++run) {
    Transports transports({.send = {address}, .receive = {}});
    for (std::uint32_t i = 0; i < 10; ++i) {
      transports.send(motion_packet(10 * run + i));
    }
  }
  Reader reader(address);
  EXPECT_EQ(read_all(reader), 20U);
  EXPECT_EQ(reader.bus().missing, 0U);
}

TEST(FlatFile, IsOfOneRun_AndOfItsUserAlone) {
  const Folder folder;
  const std::string file = folder / "flight.ccsds";
  const auto open = [&] { FlatFile(parse_address("file:" + file)); };
  const auto refused = [&] { return refusal_of<UnusableInput>(open); };
  {
    const FlatFile held(parse_address("file:" + file));
    EXPECT_EQ(refusal_of<RunFailure>(open),
              "file:" + file + ": process " + std::to_string(::getpid()) + " has it");
  }
  EXPECT_EQ(refused(), "");
  ASSERT_EQ(::chmod(file.c_str(), 0622), 0);
  EXPECT_EQ(refused(), "file:" + file + ": is open to others: mode 0622");
  ASSERT_EQ(::chmod(file.c_str(), 0600), 0);
  if (::geteuid() == 0) {
    ASSERT_EQ(::chown(file.c_str(), 65534, 65534), 0);
    EXPECT_EQ(refused(), "file:" + file + ": belongs to user 65534, not to 0");
  }
  const FlatFile nowhere(parse_address("file:/dev/null"));
  const FlatFile again(parse_address("file:/dev/null"));  // any number of runs
}

TEST(FlatFile, IsFollowedAsItGrows) {
  const Folder folder;
  const std::string address = "file:" + folder / "flight.ccsds";
  FlatFile file(parse_address(address));
  Reader reader(address);
  EXPECT_TRUE(reader.next().empty());
  const Octets packet = motion_packet(3);
  file.send(std::span(packet).first(100));
  EXPECT_TRUE(reader.next().empty());
  file.send(std::span(packet).subspan(100));
  EXPECT_EQ(reader.next(), packet);
}

TEST(FlatFile, IsReadFromItsEnd_WhereWhatIsThereIsPassedOver) {
  const Folder folder;
  const std::string address = "file:" + folder / "flight.ccsds";
  FlatFile file(parse_address(address));
  file.send(motion_packet(1));
  file.send(motion_packet(2));
  Reader reader(address);
  EXPECT_EQ(reader.next(), motion_packet(1));
  EXPECT_EQ(reader.to_end(), 0);
  EXPECT_TRUE(reader.next().empty());
  file.send(motion_packet(7));
  EXPECT_EQ(reader.next(), motion_packet(7));
  EXPECT_EQ(reader.bus().missing, 0U);
  EXPECT_EQ(reader.bus().damaged_octets, 0U);
}

TEST(DamagedStream, LosesOnlyThePacketsThatTheDamageTouched) {
  Rng rng(11, 5);
  for (int round = 0; round < 40; ++round) {
    const Folder folder;
    Octets stream = stream_of(100);
    const std::size_t hit = 1 + rng.below(98);
    stream[hit * kMotionPacketOctets + rng.below(kMotionPacketOctets)] ^= 0x10;
    Reader reader(written(folder, stream));
    EXPECT_EQ(read_all(reader), 99U) << hit;
    EXPECT_EQ(reader.bus().missing, 1U);
    EXPECT_EQ(reader.bus().damaged_octets, kMotionPacketOctets);
  }
}

TEST(DamagedStream, WithOctetsLostOrAddedIsReadOnBehindThem) {
  const Folder folder;
  Octets stream = stream_of(20);
  stream.erase(stream.begin() + 3 * static_cast<std::ptrdiff_t>(kMotionPacketOctets) + 50);
  stream.insert(
      stream.begin() + 9 * static_cast<std::ptrdiff_t>(kMotionPacketOctets) + 77, 5, 0x09);
  Reader reader(written(folder, stream));
  EXPECT_EQ(read_all(reader), 18U);
  EXPECT_EQ(reader.bus().missing, 2U);
}

TEST(DamagedStream, OfNoiseHoldsNoPacket) {
  const Folder folder;
  Rng rng(12, 6);
  Octets noise(200'000);
  for (std::uint8_t& octet : noise) octet = static_cast<std::uint8_t>(rng.below(256));
  Reader reader(written(folder, noise));
  EXPECT_EQ(read_all(reader), 0U);
  EXPECT_GT(reader.bus().damaged_octets, 190'000U);
}

TEST(Client, DecodesWhatWasPacked) {
  MotionState state;
  state.pose_valid = true;
  state.p_CT = {1.0, -2.0, 3.5};
  state.frame = 77;
  state.cov_pose[20] = 0.25;
  Octets octets(kMotionPacketOctets);
  ASSERT_EQ(encode_motion(state, {}, 5, octets), octets.size());
  polhode_motion motion{};
  ASSERT_EQ(polhode_decode(octets.data(), octets.size(), POLHODE_MOTION, &motion, sizeof motion),
            0);
  EXPECT_EQ(motion.frame, 77U);
  EXPECT_EQ(motion.p_CT[2], 3.5);
  EXPECT_EQ(motion.cov_pose[20], 0.25F);
  EXPECT_EQ(motion.flags, POLHODE_MOTION_POSE);
  octets[40] ^= 1;
  EXPECT_EQ(polhode_decode(octets.data(), octets.size(), POLHODE_MOTION, &motion, sizeof motion),
            -1);
  polhode_event event{};
  octets[40] ^= 1;
  EXPECT_EQ(polhode_decode(octets.data(), octets.size(), POLHODE_EVENT, &event, sizeof event), -1);
}

}  // namespace
}  // namespace polhode::platform::stream_test
