#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "errors.hpp"
#include "packets.hpp"
#include "small_files.hpp"
#include "transport/shm/ring_layout.hpp"
#include "transport/shm/ring_writer.hpp"

namespace polhode::platform::ring_test {
namespace {

/// A name of its own; the shared memory goes with the test.
class Name {
 public:
  explicit Name(const char* test) : name_("/polhode_" + std::to_string(::getpid()) + test) {}
  Name(const Name&) = delete;
  Name& operator=(const Name&) = delete;
  ~Name() { ::shm_unlink(name_.c_str()); }
  [[nodiscard]] std::string address() const { return "shm:" + name_; }
  [[nodiscard]] std::string file() const { return "/dev/shm" + name_; }

 private:
  std::string name_;
};

struct stat status_of(const Name& name) {
  struct stat status {};
  EXPECT_EQ(::lstat(name.file().c_str(), &status), 0);
  return status;
}

/// Message of a writer that does not take the name.
template <typename Problem = UnusableInput>
std::string refused(const Name& name) {
  return refusal_of<Problem>([&] { RingWriter(parse_address(name.address())); });
}

TEST(Ring, GivesEveryReaderEveryPacket) {
  const Name name("all");
  RingWriter writer(parse_address(name.address()));
  Reader a(name.address());
  Reader b(name.address());
  ASSERT_EQ(a.opened(), 0);
  for (std::uint32_t i = 0; i < 3000; ++i) {
    writer.send(motion_packet(i));
    ASSERT_EQ(a.next(), motion_packet(i));
    ASSERT_EQ(b.next(), motion_packet(i));
  }
  EXPECT_TRUE(a.next().empty());
}

TEST(Ring, IsForItsOwnerAlone) {
  const Name name("mode");
  const RingWriter writer(parse_address(name.address()));
  struct stat status {};
  ASSERT_EQ(::stat(name.file().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600U);
}

TEST(Ring, TakesOneWriter_AndNamesTheOneThatHasIt) {
  const Name name("one");
  const RingWriter writer(parse_address(name.address()));
  EXPECT_EQ(refused<RunFailure>(name),
            name.address() + ": process " + std::to_string(::getpid()) + " has it");
}

/// A unit whose start ends with status 2 is not started again.
TEST(Ring, WithoutAFreeDescriptorIsNoFaultOfTheSettings) {
  const Name name("descriptors");
  const FewFiles none(0);
  EXPECT_NE(refused<RunFailure>(name).find("Too many open files"), std::string::npos);
}

/// One packet in a whole ring, made beforehand by somebody.
void forge(const Name& name) {
  RingWriter forger(parse_address(name.address()));
  forger.send(motion_packet(666));
}

TEST(Ring, OfAnotherUserIsNeitherWrittenNorRead) {
  if (::geteuid() != 0) {
    GTEST_SKIP() << "only root can give a file to another user";
  }
  const Name name("theirs");
  forge(name);
  ASSERT_EQ(::chown(name.file().c_str(), 65534, 65534), 0);
  const ino_t theirs = status_of(name).st_ino;
  EXPECT_EQ(refused(name), name.address() + ": belongs to user 65534, not to 0");
  EXPECT_EQ(status_of(name).st_ino, theirs);
  EXPECT_EQ(Reader(name.address()).opened(), -EPERM);
}

TEST(Ring, ThatWasOpenToOthersIsReplaced_AndNotRead) {
  const Name name("open");
  forge(name);
  ASSERT_EQ(::chmod(name.file().c_str(), 0620), 0);
  EXPECT_EQ(Reader(name.address()).opened(), -EPERM);
  const int theirs = ::open(name.file().c_str(), O_RDWR);  // who had it open keeps the old one
  ASSERT_GE(theirs, 0);
  RingWriter writer(parse_address(name.address()));
  EXPECT_EQ(status_of(name).st_mode & 0777, 0600U);
  struct stat old {};
  ASSERT_EQ(::fstat(theirs, &old), 0);
  EXPECT_EQ(old.st_nlink, 0U);
  ::close(theirs);
  Reader reader(name.address());
  writer.send(motion_packet(1));
  EXPECT_EQ(reader.next(), motion_packet(1));
  EXPECT_TRUE(reader.next().empty());
}

TEST(Ring, LeftOfAnotherSizeOrLayoutIsReplaced_AndWhoMappedItKeepsIt) {
  const Name name("stale");
  for (const bool same_size : {false, true}) {
    const int fd = ::shm_open(name.file().c_str() + 8, O_RDWR | O_CREAT, 0600);
    ASSERT_GE(fd, 0);
    constexpr std::size_t kLonger = sizeof(ring::Ring) + 4096;
    const std::size_t octets = same_size ? sizeof(ring::Ring) : kLonger;
    ASSERT_EQ(::ftruncate(fd, static_cast<off_t>(octets)), 0);
    const auto* mapped =
        static_cast<const std::uint8_t*>(::mmap(nullptr, octets, PROT_READ, MAP_SHARED, fd, 0));
    ::close(fd);
    RingWriter writer(parse_address(name.address()));
    EXPECT_EQ(mapped[octets - 1], 0);  // SIGBUS had it been cut
    ::munmap(const_cast<std::uint8_t*>(mapped), octets);
    Reader reader(name.address());
    writer.send(motion_packet(2));
    EXPECT_EQ(reader.next(), motion_packet(2));
    ::shm_unlink(name.file().c_str() + 8);
  }
}

TEST(Ring, IsNoLink) {
  const Name name("link");
  const Folder folder;
  ASSERT_EQ(::symlink((folder / "elsewhere").c_str(), name.file().c_str()), 0);
  EXPECT_NE(refused(name), "");
  EXPECT_LT(Reader(name.address()).opened(), 0);
  struct stat status {};
  EXPECT_NE(::stat((folder / "elsewhere").c_str(), &status), 0);
  ::unlink(name.file().c_str());
}

TEST(Ring, TellsASlowReaderWhatWasOverwritten) {
  const Name name("slow");
  RingWriter writer(parse_address(name.address()));
  Reader slow(name.address());
  const std::uint32_t total = 3 * ring::kSlots + 17;
  for (std::uint32_t i = 0; i < total; ++i) {
    writer.send(motion_packet(i));
  }
  std::uint32_t read = 0;
  Octets last;
  for (Octets packet = slow.next(); !packet.empty(); packet = slow.next()) {
    last = packet;
    ++read;
  }
  EXPECT_EQ(last, motion_packet(total - 1));
  EXPECT_EQ(slow.bus().overrun + read, total);
  EXPECT_GE(read, ring::kSlots / 2);
}

TEST(Ring, KeepsItsReadersWhenAWriterEndsAndAnotherComes) {
  const Name name("again");
  auto first = std::make_unique<RingWriter>(parse_address(name.address()));
  Reader reader(name.address());
  first->send(motion_packet(0));
  first.reset();
  RingWriter second(parse_address(name.address()));
  second.send(motion_packet(1));
  EXPECT_EQ(reader.next(), motion_packet(0));
  EXPECT_EQ(reader.next(), motion_packet(1));
}

TEST(Ring, WakesAReaderThatWaits) {
  const Name name("wake");
  RingWriter writer(parse_address(name.address()));
  Reader reader(name.address());
  std::thread later([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    writer.send(motion_packet(9));
  });
  EXPECT_EQ(reader.next(10'000), motion_packet(9));
  later.join();
}

TEST(Ring, NeverGivesAPacketThatIsHalfOneHalfAnother) {
  const Name name("torn");
  RingWriter writer(parse_address(name.address()));
  Reader reader(name.address());
  std::atomic<bool> done = false;
  std::thread writes([&] {
    std::vector<Octets> packets;
    for (std::uint32_t i = 0; i < 64; ++i) {
      packets.push_back(motion_packet(i));
    }
    for (std::uint32_t i = 0; i < 200'000; ++i) {
      writer.send(packets[i % 64]);
    }
    done = true;
  });
  std::uint64_t read = 0;
  while (!done || read == 0) {
    const Octets packet = reader.next(1);
    read += packet.empty() ? 0 : 1;
    if (!packet.empty()) {
      ASSERT_TRUE(bus::crc_is_right(packet));
    }
  }
  writes.join();
  while (!reader.next().empty()) {
    ++read;
  }
  // A torn packet would have failed its CRC and been counted as damage.
  EXPECT_EQ(reader.bus().damaged_octets, 0U);
  EXPECT_EQ(read + reader.bus().overrun, 200'000U);
}

TEST(Ring, OfAnotherLayoutIsRefusedByReaders) {
  const Name name("other");
  const int fd = ::shm_open(name.file().c_str() + 8, O_RDWR | O_CREAT, 0600);
  ASSERT_GE(fd, 0);
  ASSERT_EQ(::ftruncate(fd, 4096), 0);
  ::close(fd);
  EXPECT_EQ(Reader(name.address()).opened(), -EPROTO);
  EXPECT_EQ(Reader("shm:/polhode_that_is_not_there").opened(), -ENOENT);
}

}  // namespace
}  // namespace polhode::platform::ring_test
