// What a component answers to commands, as it comes over the bus.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

struct polhode_bus;

namespace polhode::platform {

/// Listens from its making on, so that the answer to a command that is sent next is not missed.
/// Each command is answered by one event. Those of other senders are told from one's own by the
/// sequence counts, where the commands have such.
class BusAnswers {
 public:
  /// @param address of telemetry, as `polhode bus follow` takes it.
  /// @throws UnusableInput: it cannot be opened.
  BusAnswers(const std::string& address, int apid_first);

  struct Commands {
    std::size_t count = 0;
    int sequence = 0;  ///< sequence count of the first; 0: they have none
  };
  /// Prints each answer as it comes.
  /// @return commands refused, of those.
  /// @throws RunFailure: no answer to one of them within the time.
  std::size_t wait(const Commands& commands, double timeout_s);

 private:
  struct Answer {
    std::size_t commands = 0;  ///< that it answers; 0: another packet
    bool refused = false;
  };
  [[nodiscard]] Answer read(std::span<const std::uint8_t> octets, const Commands& commands) const;

  struct Close {
    void operator()(polhode_bus* bus) const;
  };
  std::string address_;
  int apid_first_;
  std::unique_ptr<polhode_bus, Close> bus_;
};

}  // namespace polhode::platform
