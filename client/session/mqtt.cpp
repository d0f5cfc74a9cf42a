#include "client/session/mqtt.hpp"

#include <fmt/format.h>
#include <mosquitto.h>
#include <mqtt_protocol.h>
#include <sys/stat.h>

#include <toml++/toml.h>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <map>
#include <mutex>
#include <utility>

#include "client/session/failure.hpp"
#include "proto/values/address.hpp"
#include "proto/values/digests.hpp"
#include "proto/values/printable.hpp"

namespace dccast::client {

namespace {

constexpr const char* plain = "mqtt://";
constexpr const char* over_tls = "mqtts://";
constexpr int at_least_once = 1;
constexpr int keep_alive_s = 15;
/// How long the broker keeps messages for a connection that is lost [s].
constexpr std::uint32_t session_expiry_s = 600;
/// A broker drops larger messages without a word [bytes]. Far above the longest line that is read,
/// so that one that is too long arrives and is reported.
constexpr std::uint32_t largest_packet = 1 << 24;
constexpr std::chrono::seconds longest_answer{10};

[[noreturn]] void refuse_topic(const std::string& text, const std::string& fault) {
  throw invalid(fmt::format("\"{}\": {}; permitted: mqtt://HOST[:PORT]/TOPIC, over TLS mqtts://...",
                            values::shown(text), fault));
}

/// Properties of a packet, which the library wants as a list of its own.
class Properties {
public:
  Properties() = default;
  Properties(const Properties&) = delete;
  ~Properties() { mosquitto_property_free_all(&list_); }

  Properties& add(int identifier, std::uint32_t value) {
    mosquitto_property_add_int32(&list_, identifier, value);
    return *this;
  }
  const mosquitto_property* list() const { return list_; }

private:
  mosquitto_property* list_ = nullptr;
};

/// The library is ready as long as the process lives.
void start_library() {
  static const int started = mosquitto_lib_init();
  if (started != MOSQ_ERR_SUCCESS)
    throw CommandFailed(ExitCode::unreachable, "MQTT cannot be used");
}

std::string error_reason(int error) {
  return error == MOSQ_ERR_ERRNO ? std::strerror(errno) : mosquitto_strerror(error);
}

const char* or_null(const std::string& text) {
  return text.empty() ? nullptr : text.c_str();
}

}  // namespace

bool is_topic(const std::string& text) {
  return text.starts_with(plain) || text.starts_with(over_tls);
}

Topic parse_topic(const std::string& text) {
  if (!is_topic(text)) refuse_topic(text, "is no address of a topic");
  Topic topic;
  topic.over_tls = text.starts_with(over_tls);
  const std::string rest = text.substr(std::strlen(topic.over_tls ? over_tls : plain));

  const std::size_t slash = rest.find('/');
  if (slash == std::string::npos || slash + 1 == rest.size())
    refuse_topic(text, "the topic is missing");
  topic.name = rest.substr(slash + 1);
  // The password is not repeated.
  if (rest.substr(0, slash).find('@') != std::string::npos)
    throw invalid(
        "the address of a topic names a user; permitted: mqtt://HOST[:PORT]/TOPIC; user and "
        "password belong into the file of --broker");
  const std::string address = rest.substr(0, slash);
  const values::HostAndPort place = values::host_and_port(address);
  if (place.host.empty()) refuse_topic(text, "the host is missing");
  topic.host = place.host;

  constexpr int plain_port = 1883, tls_port = 8883;
  topic.port = topic.over_tls ? tls_port : plain_port;
  if (!place.port.empty()) topic.port = values::port_of(address).value_or(0);
  if (topic.port == 0) refuse_topic(text, "the port is not between 1 and 65535");
  return topic;
}

BrokerLogin read_broker_login(const std::string& file) {
  BrokerLogin login;
  if (file.empty()) return login;
  struct stat status;
  if (::stat(file.c_str(), &status) != 0)
    throw invalid(fmt::format("{} cannot be read: {}", file, std::strerror(errno)));
  if ((status.st_mode & 0077) != 0)
    throw invalid(
        fmt::format("{}: other users may read the password in it; chmod 600 {}", file, file));

  // A key that is misspelt would connect without the login.
  const std::map<std::string, std::string*> texts{{"user", &login.user},
                                                  {"password", &login.password},
                                                  {"ca", &login.ca},
                                                  {"certificate", &login.certificate},
                                                  {"key", &login.key}};
  try {
    for (const auto& [key, node] : toml::parse_file(file)) {
      const auto text = texts.find(std::string(key.str()));
      const auto value = node.value<std::string>();
      if (text == texts.end() || !value)
        throw invalid(
            fmt::format("{}: {}: permitted: texts with the keys user, password, ca, "
                        "certificate, key; remove or quote it",
                        file, values::shown(key.str())));
      *text->second = *value;
    }
  } catch (const toml::parse_error& error) {
    throw invalid(fmt::format("{}: not valid TOML: {}", file,
                              values::shortened(std::string(error.description()), 200)));
  }
  return login;
}

/// What the connection and its thread share.
class MqttConnection::Session {
public:
  Session(Topic topic, const BrokerLogin& login, Handlers handlers)
      : topic_(std::move(topic)), handlers_(std::move(handlers)) {
    start_library();
    const std::string id = "dccast-" + values::random_uuid();
    client_ = mosquitto_new(id.c_str(), false, this);
    if (!client_) throw CommandFailed(ExitCode::unreachable, "MQTT cannot be used");
    try {
      prepare(login);
      connect();
    } catch (...) {
      end();
      throw;
    }
  }
  Session(const Session&) = delete;
  ~Session() { end(); }

  void publish(const std::string& text) {
    const int error =
        mosquitto_publish_v5(client_, nullptr, topic_.name.c_str(), static_cast<int>(text.size()),
                             text.data(), at_least_once, false, nullptr);
    // Without a connection the library keeps the message until there is one.
    if (error != MOSQ_ERR_SUCCESS && error != MOSQ_ERR_NO_CONN)
      handlers_.remark(fmt::format("{} takes no message: {}", broker(), error_reason(error)));
  }

private:
  std::string broker() const {
    return fmt::format("the broker at {}:{}", topic_.host, topic_.port);
  }

  [[noreturn]] void fail(const std::string& reason) const {
    throw CommandFailed(ExitCode::unreachable, fmt::format("{} {}", broker(), reason));
  }

  void require(int error, const std::string& action) const {
    if (error != MOSQ_ERR_SUCCESS) fail(fmt::format("{}: {}", action, error_reason(error)));
  }

  /// Options, login and callbacks, before there is a thread.
  void prepare(const BrokerLogin& login) {
    mosquitto_int_option(client_, MOSQ_OPT_PROTOCOL_VERSION, MQTT_PROTOCOL_V5);
    // Between 1 and 10 s, doubled each time: a broker that restarts is not stormed.
    mosquitto_reconnect_delay_set(client_, 1, 10, true);
    if (!login.user.empty())
      mosquitto_username_pw_set(client_, login.user.c_str(), or_null(login.password));
    if (topic_.over_tls) {
      const char* const folder = login.ca.empty() ? "/etc/ssl/certs" : nullptr;
      require(mosquitto_tls_set(client_, or_null(login.ca), folder, or_null(login.certificate),
                                or_null(login.key), nullptr),
              "cannot be asked with these certificates");
    }

    mosquitto_connect_v5_callback_set(
        client_, [](mosquitto*, void* self, int reason, int, const mosquitto_property*) {
          static_cast<Session*>(self)->connected(reason);
        });
    mosquitto_subscribe_v5_callback_set(client_, [](mosquitto*, void* self, int, int count,
                                                    const int* granted, const mosquitto_property*) {
      static_cast<Session*>(self)->subscribed(count > 0 ? granted[0] : MQTT_RC_UNSPECIFIED);
    });
    mosquitto_disconnect_v5_callback_set(
        client_, [](mosquitto*, void* self, int reason, const mosquitto_property*) {
          static_cast<Session*>(self)->disconnected(reason);
        });
    mosquitto_message_callback_set(client_,
                                   [](mosquitto*, void* self, const mosquitto_message* message) {
                                     static_cast<Session*>(self)->handlers_.message(
                                         {static_cast<const char*>(message->payload),
                                          static_cast<std::size_t>(message->payloadlen)});
                                   });
  }

  /// Connects and waits for the answer to that and to the subscription.
  void connect() {
    Properties properties;
    properties.add(MQTT_PROP_SESSION_EXPIRY_INTERVAL, session_expiry_s)
        .add(MQTT_PROP_MAXIMUM_PACKET_SIZE, largest_packet);
    require(mosquitto_connect_bind_v5(client_, topic_.host.c_str(), topic_.port, keep_alive_s,
                                      nullptr, properties.list()),
            "does not answer");
    require(mosquitto_loop_start(client_), "cannot be used");

    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, longest_answer, [this] { return ready_ || !refusal_.empty(); });
    if (!refusal_.empty()) fail("refuses: " + refusal_);
    if (!ready_) fail("does not answer as a broker of MQTT 5");
  }

  /// Ends the session at the broker too, which then keeps nothing for it.
  void end() {
    {
      const std::lock_guard lock(mutex_);
      ends_ = true;
    }
    Properties at_once;
    at_once.add(MQTT_PROP_SESSION_EXPIRY_INTERVAL, 0);
    mosquitto_disconnect_v5(client_, MQTT_RC_NORMAL_DISCONNECTION, at_once.list());
    mosquitto_loop_stop(client_, false);
    mosquitto_destroy(client_);
  }

  void connected(int reason) {
    if (reason != 0) return refused(mosquitto_reason_string(reason));
    if (!handlers_.message) return become_ready();
    const int error = mosquitto_subscribe_v5(client_, nullptr, topic_.name.c_str(), at_least_once,
                                             MQTT_SUB_OPT_SEND_RETAIN_NEVER, nullptr);
    if (error != MOSQ_ERR_SUCCESS) refused("the topic: " + error_reason(error));
  }

  void subscribed(int granted) {
    constexpr int first_failure = 0x80;
    if (granted >= first_failure)
      refused(fmt::format("the topic {}: {}", topic_.name, mosquitto_reason_string(granted)));
    else
      become_ready();
  }

  void become_ready() {
    bool again = false;
    {
      const std::lock_guard lock(mutex_);
      again = std::exchange(ready_, true);
    }
    changed_.notify_all();
    if (again) handlers_.remark(broker() + " is there again");
  }

  void refused(const std::string& reason) {
    bool again = false;
    {
      const std::lock_guard lock(mutex_);
      refusal_ = reason + "; see the login in the file of --broker";
      again = ready_;
    }
    changed_.notify_all();
    if (again) handlers_.remark(fmt::format("{} refuses now: {}", broker(), reason));
  }

  void disconnected(int reason) {
    {
      const std::lock_guard lock(mutex_);
      if (ends_ || !ready_) return;
    }
    handlers_.remark(
        fmt::format("{} is away ({}); it is tried again", broker(), error_reason(reason)));
  }

  Topic topic_;
  Handlers handlers_;
  mosquitto* client_ = nullptr;

  /// Guards what follows.
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ready_ = false;  ///< connected, and subscribed
  bool ends_ = false;
  std::string refusal_;  ///< of the broker
};

MqttConnection::MqttConnection(const Topic& topic, const BrokerLogin& login, Handlers handlers)
    : session_(std::make_unique<Session>(topic, login, std::move(handlers))) {}

MqttConnection::~MqttConnection() = default;

void MqttConnection::publish(const std::string& text) {
  session_->publish(text);
}

}  // namespace dccast::client
