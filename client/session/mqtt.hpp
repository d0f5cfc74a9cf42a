#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace dccast::client {

/// Receives a sentence for the user.
using Remark = std::function<void(const std::string&)>;

/// A topic of an MQTT broker: "mqtt://HOST[:PORT]/TOPIC", over TLS "mqtts://...".
struct Topic {
  std::string host;
  int port = 0;
  bool over_tls = false;
  std::string name;
};

/// Whether a text is meant as the address of a topic, not as a file.
bool is_topic(const std::string& text);
/// Throws CommandFailed: it is no address of a topic.
Topic parse_topic(const std::string& text);

/// What a broker knows us by. Empty where it is not needed.
struct BrokerLogin {
  std::string user, password;
  std::string ca, certificate, key;  ///< files in PEM
};

/// Reads a file of TOML with the keys user, password, ca, certificate and key; nothing where `file`
/// is empty. Throws CommandFailed: it cannot be read, other users may read it, or it has faults.
BrokerLogin read_broker_login(const std::string& file);

/// A connection to a broker that speaks MQTT 5. A lost one is restored by a thread of its own, and
/// for ten minutes the broker keeps what comes meanwhile.
class MqttConnection {
public:
  /// What happens on the connection, in its thread.
  struct Handlers {
    std::function<void(std::string_view)> message{};  ///< empty: nothing is subscribed
    Remark remark;                                    ///< the connection is lost, or there again
  };

  /// Connects, and subscribes to the topic where messages are wanted. What the broker kept from
  /// before is not received. Throws CommandFailed: the broker does not answer, or refuses.
  MqttConnection(const Topic& topic, const BrokerLogin& login, Handlers handlers);
  MqttConnection(const MqttConnection&) = delete;
  ~MqttConnection();

  /// Publishes a text on the topic, at least once; while the broker is away it waits.
  void publish(const std::string& text);

private:
  class Session;
  std::unique_ptr<Session> session_;
};

}  // namespace dccast::client
