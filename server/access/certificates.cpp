#include "server/access/certificates.hpp"

#include <arpa/inet.h>
#include <fmt/core.h>
#include <netinet/in.h>
#include <openssl/bio.h>
#include <openssl/ec.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>
#include <time.h>

#include <array>
#include <cstdint>

#include "core/storage/file.hpp"
#include "proto/values/digests.hpp"
#include "proto/values/owned.hpp"
#include "server/access/users.hpp"

namespace dccast::access {

namespace {

using Key = values::Owned<EVP_PKEY, EVP_PKEY_free>;
using X509Pointer = values::Owned<X509, X509_free>;
using Bio = values::Owned<BIO, BIO_free>;

constexpr int ca_days = 3650;
// Clients whose clock is slow accept a new certificate, too.
constexpr long backdated_s = 3600;

[[noreturn]] void fail(const std::string& fault) {
  std::array<char, 256> reason{};
  ERR_error_string_n(ERR_get_error(), reason.data(), reason.size());
  throw Refused(fmt::format("{}: {}", fault, reason.data()));
}

/// @param write  to a BIO
template <class Write>
std::string write_pem(Write write) {
  const Bio bio(BIO_new(BIO_s_mem()));
  write(bio.get());
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &bytes);
  return {bytes, static_cast<std::size_t>(size)};
}

std::string to_pem(X509* certificate) {
  return write_pem([&](BIO* bio) { PEM_write_bio_X509(bio, certificate); });
}

std::string to_pem(EVP_PKEY* key) {
  return write_pem(
      [&](BIO* bio) { PEM_write_bio_PrivateKey(bio, key, nullptr, nullptr, 0, nullptr, nullptr); });
}

Bio open_reader(const std::string& text) {
  return Bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

X509Pointer parse(const std::string& pem, const std::string& where) {
  X509Pointer certificate(PEM_read_bio_X509(open_reader(pem).get(), nullptr, nullptr, nullptr));
  if (!certificate) fail(fmt::format("{} holds no certificate in PEM form", where));
  return certificate;
}

void extend(X509* certificate, X509* issuer, int kind, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, &context, kind, value.c_str());
  if (extension == nullptr) fail(fmt::format("a certificate cannot state {}", value));
  X509_add_ext(certificate, extension, -1);
  X509_EXTENSION_free(extension);
}

/// Content of a certificate to be made.
struct Content {
  std::string name;
  int days = 0;
  std::vector<std::pair<int, std::string>> extensions;
};

/// A certificate for `key`. @param issuer, issuer_key  null: signs itself
X509Pointer make(const Content& content, EVP_PKEY* key, X509* issuer, EVP_PKEY* issuer_key) {
  X509Pointer made(X509_new());
  X509_set_version(made.get(), 2);

  std::array<unsigned char, 16> serial;
  if (RAND_bytes(serial.data(), serial.size()) != 1) fail("no random numbers");
  serial[0] &= 0x7f;  // a serial number is positive
  BIGNUM* number = BN_bin2bn(serial.data(), serial.size(), nullptr);
  BN_to_ASN1_INTEGER(number, X509_get_serialNumber(made.get()));
  BN_free(number);

  X509_gmtime_adj(X509_getm_notBefore(made.get()), -backdated_s);
  X509_time_adj_ex(X509_getm_notAfter(made.get()), content.days, 0, nullptr);
  X509_set_pubkey(made.get(), key);

  X509_NAME* subject = X509_get_subject_name(made.get());
  X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_UTF8,
                             reinterpret_cast<const unsigned char*>(content.name.c_str()), -1, -1,
                             0);
  X509_set_issuer_name(made.get(), issuer ? X509_get_subject_name(issuer) : subject);

  for (const auto& [kind, value] : content.extensions)
    extend(made.get(), issuer ? issuer : made.get(), kind, value);

  if (X509_sign(made.get(), issuer_key ? issuer_key : key, EVP_sha256()) == 0)
    fail("a certificate cannot be signed");
  return made;
}

bool is_address(const std::string& name) {
  std::array<unsigned char, 16> bytes;
  return ::inet_pton(AF_INET, name.c_str(), bytes.data()) == 1 ||
         ::inet_pton(AF_INET6, name.c_str(), bytes.data()) == 1;
}

std::string alternative_names(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) {
    if (name.empty() || name.find_first_of(",: \n") != std::string::npos) {
      if (!is_address(name)) throw Refused(fmt::format("\"{}\" is no name of a host", name));
    }
    text += fmt::format("{}{}:{}", text.empty() ? "" : ",", is_address(name) ? "IP" : "DNS", name);
  }
  return text;
}

std::int64_t unix_time(const ASN1_TIME* time) {
  tm parts{};
  ASN1_TIME_to_tm(time, &parts);
  return ::timegm(&parts);
}

std::string to_string(const GENERAL_NAME& name) {
  if (name.type == GEN_DNS) {
    const ASN1_STRING* text = name.d.dNSName;
    return {reinterpret_cast<const char*>(ASN1_STRING_get0_data(text)),
            static_cast<std::size_t>(ASN1_STRING_length(text))};
  }
  if (name.type != GEN_IPADD) return "";
  std::array<char, INET6_ADDRSTRLEN> text{};
  const int family = ASN1_STRING_length(name.d.iPAddress) == 4 ? AF_INET : AF_INET6;
  ::inet_ntop(family, ASN1_STRING_get0_data(name.d.iPAddress), text.data(), text.size());
  return text.data();
}

std::vector<std::string> alternative_names(X509* certificate) {
  auto* extension = static_cast<GENERAL_NAMES*>(
      X509_get_ext_d2i(certificate, NID_subject_alt_name, nullptr, nullptr));
  std::vector<std::string> names;
  for (int i = 0; i < sk_GENERAL_NAME_num(extension); ++i)
    if (std::string name = to_string(*sk_GENERAL_NAME_value(extension, i)); !name.empty())
      names.push_back(std::move(name));
  GENERAL_NAMES_free(extension);
  return names;
}

/// A certificate with its key.
struct Identity {
  X509Pointer certificate;
  Key key;
};

Identity read_issuer(const std::filesystem::path& certificate, const std::filesystem::path& key) {
  const std::string text = storage::read_file(key, storage::Links::follow);
  Identity issuer{
      parse(storage::read_file(certificate, storage::Links::follow), certificate.string()),
      Key(PEM_read_bio_PrivateKey(open_reader(text).get(), nullptr, nullptr, nullptr))};
  if (!issuer.key) fail(fmt::format("{} holds no private key", key.string()));
  return issuer;
}

Key new_key() {
  Key key(EVP_EC_gen("P-256"));
  if (!key) fail("no key can be made");
  return key;
}

/// @param usage  "serverAuth" or "clientAuth"  @param names  alternative ones; may be empty
Identity issue(const Identity& issuer, const std::string& name, int days, const std::string& usage,
               const std::vector<std::string>& names) {
  Content content{name,
                  days,
                  {{NID_basic_constraints, "critical,CA:FALSE"},
                   {NID_key_usage, "critical,digitalSignature"},
                   {NID_ext_key_usage, usage},
                   {NID_authority_key_identifier, "keyid"}}};
  if (!names.empty())
    content.extensions.emplace_back(NID_subject_alt_name, alternative_names(names));

  Key key = new_key();
  X509Pointer made = make(content, key.get(), issuer.certificate.get(), issuer.key.get());
  return {std::move(made), std::move(key)};
}

}  // namespace

std::string signature_fault(const std::string& pem, const std::string& ca_pem) {
  using Store = values::Owned<X509_STORE, X509_STORE_free>;
  using StoreContext = values::Owned<X509_STORE_CTX, X509_STORE_CTX_free>;
  const X509Pointer ca = parse(ca_pem, "the CA");

  // The server's certificate, then those between it and the CA.
  const Bio reader = open_reader(pem);
  std::vector<X509Pointer> certificates;
  for (;;) {
    X509Pointer next(PEM_read_bio_X509(reader.get(), nullptr, nullptr, nullptr));
    if (!next) break;
    certificates.push_back(std::move(next));
  }
  ERR_clear_error();
  if (certificates.empty()) return "it holds no certificate";

  STACK_OF(X509)* const between = sk_X509_new_null();
  for (const X509Pointer& certificate : certificates) sk_X509_push(between, certificate.get());
  const Store store(X509_STORE_new());
  X509_STORE_add_cert(store.get(), ca.get());
  const StoreContext context(X509_STORE_CTX_new());
  X509_STORE_CTX_init(context.get(), store.get(), certificates.front().get(), between);
  const bool trusted = X509_verify_cert(context.get()) == 1;
  const int error = X509_STORE_CTX_get_error(context.get());
  sk_X509_free(between);
  return trusted ? "" : X509_verify_cert_error_string(error);
}

bool is_for(const std::string& pem, const std::string& host) {
  const X509Pointer certificate = parse(pem, "the certificate");
  return X509_check_host(certificate.get(), host.c_str(), host.size(), 0, nullptr) == 1 ||
         X509_check_ip_asc(certificate.get(), host.c_str(), 0) == 1;
}

Certificate read_certificate(const std::string& pem, const std::string& where) {
  const X509Pointer parsed = parse(pem, where);

  Certificate certificate;
  std::array<char, 256> name{};
  X509_NAME_get_text_by_NID(X509_get_subject_name(parsed.get()), NID_commonName, name.data(),
                            name.size());
  certificate.name = name.data();

  certificate.names = alternative_names(parsed.get());
  certificate.begins_unix = unix_time(X509_get0_notBefore(parsed.get()));
  certificate.ends_unix = unix_time(X509_get0_notAfter(parsed.get()));

  std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
  unsigned size = 0;
  X509_digest(parsed.get(), EVP_sha256(), digest.data(), &size);
  certificate.sha256 = values::hexadecimal({digest.data(), size});

  return certificate;
}

bool Pki::exists() const {
  std::error_code error;
  return std::filesystem::exists(ca_key(), error);
}

void Pki::init() const {
  if (exists())
    throw Refused(
        fmt::format("there is a CA in {} already; remove that folder to begin anew: all "
                    "clients then log in again",
                    directory_.string()));

  std::filesystem::create_directories(directory_);
  std::filesystem::permissions(directory_, std::filesystem::perms::owner_all);

  // The random name distinguishes the CAs of several daemons; trust depends on the fingerprint.
  const Key key = new_key();
  const std::string name = fmt::format("dccast CA {}", values::random_hexadecimal(4));
  const X509Pointer ca = make({name,
                               ca_days,
                               {{NID_basic_constraints, "critical,CA:TRUE,pathlen:0"},
                                {NID_key_usage, "critical,keyCertSign,cRLSign"},
                                {NID_subject_key_identifier, "hash"}}},
                              key.get(), nullptr, nullptr);

  storage::replace_file(this->ca(), to_pem(ca.get()));
  storage::replace_file(ca_key(), to_pem(key.get()));
}

void Pki::issue_server(const std::vector<std::string>& names, int days) const {
  if (names.empty()) throw Refused("a certificate of a server needs a name");
  const Identity issuer = read_issuer(ca(), ca_key());
  const Identity made = issue(issuer, names.front().substr(0, 64), days, "serverAuth", names);
  storage::replace_file(server_key(), to_pem(made.key.get()));

  // The CA is included, so that a client can compare its fingerprint before it trusts the server.
  storage::replace_file(server(),
                        to_pem(made.certificate.get()) + to_pem(issuer.certificate.get()));
}

void Pki::issue_user(const std::string& user, int days,
                     const std::filesystem::path& directory) const {
  const Identity made = issue(read_issuer(ca(), ca_key()), user, days, "clientAuth", {});
  storage::replace_file(directory / (user + ".key"), to_pem(made.key.get()));
  storage::replace_file(directory / (user + ".pem"), to_pem(made.certificate.get()));
}

}  // namespace dccast::access
