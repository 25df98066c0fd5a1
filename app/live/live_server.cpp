#include "app/live/live_server.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <openssl/crypto.h>
#include <sys/random.h>

#include <array>
#include <atomic>
#include <boost/asio/ip/host_name.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <map>
#include <opencv2/imgproc.hpp>
#include <set>
#include <thread>
#include <utility>

#include "app/live/client_words.hpp"
#include "app/live/page_files.hpp"
#include "app/report/picture.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/statistics.hpp"

namespace ballservo {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using Error = boost::system::error_code;
using Request = http::request<http::empty_body>;
using namespace std::chrono_literals;

constexpr std::uint32_t most_request_bytes = 8192;
constexpr std::size_t most_message_bytes = 1 << 20;  // a colours file is the largest
constexpr std::size_t most_answers = 64, latencies_kept = 200;
constexpr long most_connections = 64;
constexpr int widest_picture_px = 1280, jpeg_quality = 80;
constexpr auto silence = 30s;  // of a client, before it is asked whether it is still there, and then let go

/// 128 bits that nobody can guess.
std::string new_secret() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw std::runtime_error("the system gives no random numbers");
  return fmt::format("{:02x}", fmt::join(bytes, ""));
}

/// An address of this machine that others can reach, for who listens on all of them.
std::string reachable_address() {
  std::string address = asio::ip::host_name();
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return address;
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) continue;
    if ((entry->ifa_flags & IFF_LOOPBACK) != 0 || (entry->ifa_flags & IFF_UP) == 0) continue;
    std::array<char, INET_ADDRSTRLEN> text{};
    const auto* const ip = reinterpret_cast<const sockaddr_in*>(entry->ifa_addr);
    if (::inet_ntop(AF_INET, &ip->sin_addr, text.data(), text.size()) != nullptr) address = text.data();
    break;
  }
  ::freeifaddrs(list);
  return address;
}

std::string quoted(const asio::ip::address& address) {
  return address.is_v6() ? "[" + address.to_string() + "]" : address.to_string();
}

}  // namespace

class LiveServer::Impl {
 public:
  Impl(const LiveServerOptions& options, LiveExchange& exchange);
  ~Impl();
  const std::string& url() const { return url_; }

 private:
  class Connection;
  class Client;

  void accept();
  void note_views();
  bool knows_host(std::string_view host) const;
  bool is_from_page(const Request& request) const;
  void note_latency(double latency_ms);
  double latency_p95_ms() const;
  std::shared_ptr<const std::string> message(const std::shared_ptr<const LiveMoment>& moment,
                                             const std::string& view);

  LiveServerOptions options_;
  LiveExchange& exchange_;
  const std::shared_ptr<const void> present_ = std::make_shared<char>();  // each connection has a share
  const std::shared_ptr<asio::io_context> io_ = std::make_shared<asio::io_context>(1);  // and each answer
  tcp::acceptor acceptor_{*io_};
  asio::steady_timer pause_{*io_};
  std::string secret_, url_;
  std::set<Client*> clients_;  // that are open
  std::deque<double> latencies_ms_;
  std::atomic<bool> told_{false};
  std::map<std::string, std::shared_ptr<const std::string>> encoded_;  // by view; once for all clients
  std::uint64_t encoded_serial_ = 0;
  std::thread thread_;
};

/// A client of the WebSocket.
class LiveServer::Impl::Client : public std::enable_shared_from_this<Client> {
 public:
  /// `reads_stream`: another program, which is sent the newest line and says nothing.
  Client(Impl& server, beast::tcp_stream&& stream, bool reads_stream)
      : server_(server),
        socket_(std::move(stream)),
        reads_stream_(reads_stream),
        view_(reads_stream ? stream_view : "") {}

  void start(const Request& request) {
    beast::get_lowest_layer(socket_).expires_never();  // the WebSocket has times of its own
    socket_.set_option(websocket::stream_base::timeout{server_.options_.patience, silence, true});
    socket_.read_message_max(most_message_bytes);
    socket_.auto_fragment(false);
    socket_.async_accept(request, [self = shared_from_this()](Error error) {
      if (error) return;
      self->open_ = true;
      self->server_.clients_.insert(self.get());
      self->server_.note_views();
      self->read();
    });
  }

  const std::string& view() const { return view_; }

  /// Sends what is due: an answer, or the newest moment, if the client has painted what it had.
  void pump() {
    if (!open_ || writing_) return;
    if (!answers_.empty()) {
      const auto answer = std::make_shared<const std::string>(std::move(answers_.front()));
      answers_.pop_front();
      return write(answer, true);
    }
    const auto moment = server_.exchange_.newest();
    if (reads_stream_) {
      if (!moment || moment->serial == sent_serial_ || moment->line.empty()) return;
      sent_serial_ = moment->serial;
      return write({moment, &moment->line}, true);
    }
    if (!has_painted_ || !moment || (moment->serial == sent_serial_ && sent_view_ == view_)) return;
    has_painted_ = false;
    sent_serial_ = moment->serial;
    sent_view_ = view_;
    sent_taken_ = moment->taken;
    write(server_.message(moment, view_), false);
  }

  void reply(const nlohmann::json& answer) {
    if (answers_.size() >= most_answers) return close();
    answers_.push_back(answer.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    pump();
  }

 private:
  void read() {
    socket_.async_read(buffer_, [self = shared_from_this()](Error error, std::size_t) {
      if (error) return self->close();
      const std::string text = beast::buffers_to_string(self->buffer_.data());
      self->buffer_.consume(self->buffer_.size());
      self->take(text);
      if (self->open_) self->read();
    });
  }

  void take(const std::string& text) {
    if (reads_stream_) return close();
    auto what = message_of(text);
    if (!what) return close();
    const std::string verb = (*what)["do"];
    if (verb == "look") {
      if (!what->contains("view") || !(*what)["view"].is_string()) return close();
      view_ = text_at(*what, "view").substr(0, 64);
      has_painted_ = true;
      server_.note_views();
      return pump();
    }
    if (verb == "painted") {
      if (!has_painted_ && sent_serial_ > 0)
        server_.note_latency(1000 * seconds_of(LiveExchange::Clock::now() - sent_taken_));
      has_painted_ = true;
      return pump();
    }
    // The session answers on a thread of its own; the client, or the server, may have gone by then.
    auto answer = [io = server_.io_, weak = weak_from_this()](nlohmann::json text_json) {
      asio::post(*io, [weak, said = std::move(text_json)] {
        if (const auto client = weak.lock()) client->reply(said);
      });
    };
    if (!server_.exchange_.put({*std::move(what), std::move(answer)}))
      reply({{"answer", verb}, {"refused", "too much is asked at once"}});
  }

  void write(const std::shared_ptr<const std::string>& message, bool is_text) {
    writing_ = true;
    socket_.text(is_text);
    socket_.async_write(asio::buffer(*message),
                        [self = shared_from_this(), message](Error error, std::size_t) {
                          self->writing_ = false;
                          if (error) return self->close();
                          self->pump();
                        });
  }

  void close() {
    if (!open_) return;
    open_ = false;
    server_.clients_.erase(this);
    Error ignored;
    beast::get_lowest_layer(socket_).socket().shutdown(tcp::socket::shutdown_both, ignored);
    beast::get_lowest_layer(socket_).close();
    server_.note_views();
  }

  Impl& server_;
  const std::shared_ptr<const void> present_ = server_.present_;
  websocket::stream<beast::tcp_stream> socket_;
  beast::flat_buffer buffer_;
  std::deque<std::string> answers_;
  bool reads_stream_;
  std::string view_, sent_view_;
  std::uint64_t sent_serial_ = 0;
  LiveExchange::Clock::time_point sent_taken_;
  bool open_ = false, writing_ = false, has_painted_ = false;
};

/// A connection that asks for the page's files, until it becomes a client.
class LiveServer::Impl::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Impl& server, tcp::socket&& socket) : server_(server), stream_(std::move(socket)) {}

  void read() {
    parser_.emplace();
    parser_->header_limit(most_request_bytes);
    parser_->body_limit(0);
    stream_.expires_after(server_.options_.patience);  // for the whole of it, however slowly it drips in
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](Error error, std::size_t) {
      if (!error) self->answer(self->parser_->release());
    });
  }

 private:
  void answer(const Request& request) {
    std::string_view path(request.target().data(), request.target().size());
    path = path.substr(0, path.find('?'));
    if (!server_.knows_host({request[http::field::host].data(), request[http::field::host].size()}))
      return say(request, http::status::forbidden, "the Host is another's\n");
    if (!server_.is_from_page(request))
      return say(request, http::status::forbidden, "the Origin is another's\n");
    if (!server_.secret_.empty()) {
      // Compared in a time that tells nothing of where they differ.
      const std::string& secret = server_.secret_;
      const bool knows = path.size() > secret.size() + 1 && path[secret.size() + 1] == '/' &&
                         CRYPTO_memcmp(path.data() + 1, secret.data(), secret.size()) == 0;
      if (!knows) return say(request, http::status::not_found, "no such page\n");
      path.remove_prefix(server_.secret_.size() + 1);
    }
    if ((path == "/socket" || path == "/stream") && websocket::is_upgrade(request))
      return std::make_shared<Client>(server_, std::move(stream_), path == "/stream")->start(request);
    if (request.method() != http::verb::get)
      return say(request, http::status::method_not_allowed, "GET alone\n");
    const auto file = path.rfind('/', 0) == 0 ? page_file(path.substr(1)) : std::nullopt;
    if (!file) return say(request, http::status::not_found, "no such page\n");
    say(request, http::status::ok, file->bytes, file->type);
  }

  void say(const Request& request, http::status status, std::string_view body,
           std::string_view type = "text/plain; charset=utf-8") {
    const auto response =
        std::make_shared<http::response<http::string_body>>(status, request.version(), std::string(body));
    const auto set = [&](http::field field, std::string_view value) {
      response->set(field, beast::string_view(value.data(), value.size()));
    };
    set(http::field::content_type, type);
    set(http::field::cache_control, "no-store");
    set(http::field::x_frame_options, "DENY");
    response->set("X-Content-Type-Options", "nosniff");
    response->set("Referrer-Policy", "no-referrer");
    response->set("Cross-Origin-Resource-Policy", "same-origin");
    const std::string host(status == http::status::ok ? request[http::field::host] : "");
    response->set("Content-Security-Policy",
                  "default-src 'self'; img-src 'self' data:; connect-src 'self' ws://" + host);
    response->keep_alive(request.keep_alive() && status == http::status::ok);
    response->prepare_payload();
    stream_.expires_after(server_.options_.patience);
    http::async_write(stream_, *response, [self = shared_from_this(), response](Error error, std::size_t) {
      if (!error && response->keep_alive()) return self->read();
      Error ignored;
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    });
  }

  Impl& server_;
  const std::shared_ptr<const void> present_ = server_.present_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{most_request_bytes + 4096};
  std::optional<http::request_parser<http::empty_body>> parser_;
};

LiveServer::Impl::Impl(const LiveServerOptions& options, LiveExchange& exchange)
    : options_(options), exchange_(exchange) {
  Error error;
  const asio::ip::address address = asio::ip::make_address(options.address, error);
  if (error) throw InputError("--listen", "'" + options.address + "'", "an IP address of this machine");
  const tcp::endpoint endpoint(address, static_cast<std::uint16_t>(options.port));
  acceptor_.open(endpoint.protocol(), error);
  if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor_.bind(endpoint, error);
  if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
  if (error)
    throw InputError("--listen, --port",
                     fmt::format("{} port {}: {}", options.address, options.port, error.message()),
                     "an address of this machine and a port that is free (0: any)");
  options_.port = acceptor_.local_endpoint().port();
  if (!address.is_loopback()) secret_ = new_secret();
  url_ = fmt::format("http://{}:{}/", address.is_unspecified() ? reachable_address() : quoted(address),
                     options_.port);
  if (!secret_.empty()) url_ += secret_ + "/";
  exchange_.set_on_publish([this] {
    if (told_.exchange(true)) return;
    asio::post(*io_, [this] {
      told_ = false;
      for (Client* client : clients_) client->pump();
    });
  });
  accept();
  thread_ = std::thread([this] { io_->run(); });
}

LiveServer::Impl::~Impl() {
  exchange_.set_on_publish({});
  io_->stop();
  thread_.join();
}

void LiveServer::Impl::accept() {
  acceptor_.async_accept([this](Error error, tcp::socket socket) {
    if (!error && present_.use_count() <= most_connections) {
      socket.set_option(tcp::no_delay(true), error);
      std::make_shared<Connection>(*this, std::move(socket))->read();
    } else if (error) {  // no more files may be opened: that passes
      pause_.expires_after(100ms);
      return pause_.async_wait([this](Error) { accept(); });
    }
    accept();
  });
}

void LiveServer::Impl::note_views() {
  std::set<std::string> views;
  for (const Client* client : clients_) views.insert(client->view());
  encoded_.clear();
  exchange_.set_views(std::move(views));
}

/// A page of somebody else's that has its name lead here (DNS rebinding) still names itself as the Host. A
/// number, this machine's name and localhost can't be made to lead elsewhere.
bool LiveServer::Impl::knows_host(std::string_view host) const {
  std::string name(host);
  const std::string port = fmt::format(":{}", options_.port);
  if (name.size() > port.size() && name.compare(name.size() - port.size(), port.size(), port) == 0)
    name.resize(name.size() - port.size());
  else if (options_.port != 80)
    return false;
  if (name == "localhost") return true;
  if (name.size() > 2 && name.front() == '[' && name.back() == ']') name = name.substr(1, name.size() - 2);
  Error error;
  const asio::ip::address address = asio::ip::make_address(name, error);
  if (secret_.empty()) return !error && address.is_loopback();
  return !error || name == asio::ip::host_name() || name == asio::ip::host_name() + ".local";
}

/// Browsers say whose page asks; other programs say nothing.
bool LiveServer::Impl::is_from_page(const Request& request) const {
  const auto origin = request.find(http::field::origin);
  return origin == request.end() || origin->value() == "http://" + std::string(request[http::field::host]);
}

void LiveServer::Impl::note_latency(double latency_ms) {
  latencies_ms_.push_back(latency_ms);
  if (latencies_ms_.size() > latencies_kept) latencies_ms_.pop_front();
}

double LiveServer::Impl::latency_p95_ms() const {
  return latencies_ms_.empty() ? 0 : quantile({latencies_ms_.begin(), latencies_ms_.end()}, 0.95);
}

/// The length of the state (4 bytes, the least first), the state, and the picture as JPEG.
std::shared_ptr<const std::string> LiveServer::Impl::message(const std::shared_ptr<const LiveMoment>& moment,
                                                             const std::string& view) {
  if (std::exchange(encoded_serial_, moment->serial) != moment->serial) encoded_.clear();
  std::shared_ptr<const std::string>& encoded = encoded_[view];
  if (encoded) return encoded;
  const auto quoted_text = [](const std::string& text) {
    return nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  };
  std::string jpeg, fault;
  try {
    cv::Mat picture = moment->draw(view);
    if (picture.cols > widest_picture_px) {
      const double scale = static_cast<double>(widest_picture_px) / picture.cols;
      cv::resize(picture, picture, {}, scale, scale, cv::INTER_AREA);
    }
    if (!picture.empty()) jpeg = picture_bytes(picture, ".jpg", {cv::IMWRITE_JPEG_QUALITY, jpeg_quality});
  } catch (const std::exception& error) {  // the page says so, and the next moment is tried again
    fault = error.what();
  }
  const std::string state =
      fmt::format(R"({{"view":{},"fault":{},"clients":{},"painted_p95_ms":{:.1f},"state":{}}})",
                  quoted_text(view), quoted_text(fault), clients_.size(), latency_p95_ms(), moment->state);
  auto message = std::make_shared<std::string>();
  for (int shift = 0; shift < 32; shift += 8)
    message->push_back(static_cast<char>((state.size() >> shift) & 0xFF));
  *message += state + jpeg;
  return encoded = message;
}

LiveServer::LiveServer(const LiveServerOptions& options, LiveExchange& exchange)
    : impl_(std::make_unique<Impl>(options, exchange)) {}
LiveServer::~LiveServer() = default;
const std::string& LiveServer::url() const { return impl_->url(); }

}  // namespace ballservo
