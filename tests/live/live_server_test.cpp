// The page's server against clients that are wrong, slow, or many.
#include "app/live/live_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <memory>
#include <thread>

#include "calibration/base/fault.hpp"
#include "calibration/base/random.hpp"

namespace ballservo {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using namespace std::chrono_literals;

cv::Mat grey_picture(const std::string& view) {
  return view == "picture" ? cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(128)) : cv::Mat();
}

class LiveServerTest : public testing::Test {
 protected:
  explicit LiveServerTest(const std::string& address = "127.0.0.1") : server({address, 0, 500ms}, exchange) {
    const std::string& url = server.url();
    const std::size_t colon = url.rfind(':');
    port = static_cast<std::uint16_t>(std::stoi(url.substr(colon + 1)));
    path = url.substr(url.find('/', colon));
    host = "127.0.0.1:" + std::to_string(port);
  }

  tcp::socket connected() {
    tcp::socket socket(io);
    socket.connect({asio::ip::make_address("127.0.0.1"), port});
    return socket;
  }
  /// All that comes until the server closes.
  static std::string rest(tcp::socket& socket) {
    std::string text;
    boost::system::error_code ended;
    asio::read(socket, asio::dynamic_buffer(text), ended);
    return text;
  }
  /// A connection that is reset while it is written to has been closed, too.
  std::string said_to(const std::string& request) {
    tcp::socket socket = connected();
    boost::system::error_code reset;
    asio::write(socket, asio::buffer(request), reset);
    return rest(socket);
  }
  std::string get(const std::string& target, const std::string& host_name, const std::string& more = "") {
    return said_to("GET " + target + " HTTP/1.1\r\nHost: " + host_name + "\r\nConnection: close\r\n" + more +
                   "\r\n");
  }
  std::string upgrade(const std::string& more) {
    tcp::socket socket = connected();
    asio::write(socket,
                asio::buffer("GET " + path + "socket HTTP/1.1\r\nHost: " + host +
                             "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                             "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
                             more + "\r\n"));
    std::string line;
    boost::system::error_code ended;
    asio::read_until(socket, asio::dynamic_buffer(line), "\r\n", ended);
    return line.substr(0, line.find("\r\n"));
  }
  std::uint64_t publish() {
    return exchange.publish({{"kind", "test"}}, std::chrono::steady_clock::now(), grey_picture);
  }

  LiveExchange exchange;
  asio::io_context io;
  LiveServer server;
  std::uint16_t port = 0;
  std::string path, host;
};

/// Waits for it.
LiveCommand command_in(LiveExchange& exchange) {
  std::vector<LiveCommand> commands;
  while (commands.empty()) commands = exchange.next_commands();
  return commands.front();
}

/// A browser's part, as far as the server can tell.
class PageClient {
 public:
  PageClient(asio::io_context& io, std::uint16_t port, const std::string& path = "/socket") : socket_(io) {
    beast::get_lowest_layer(socket_).connect({asio::ip::make_address("127.0.0.1"), port});
    socket_.handshake("127.0.0.1:" + std::to_string(port), path);
  }
  std::string hear_text() {
    beast::flat_buffer buffer;
    socket_.read(buffer);
    return beast::buffers_to_string(buffer.data());
  }
  void say(const nlohmann::json& what) { socket_.write(asio::buffer(what.dump())); }
  /// The next moment's serial, or the answer to what was asked.
  nlohmann::json hear() {
    std::string text = hear_text();
    if (socket_.got_text()) return nlohmann::json::parse(text);
    std::uint32_t size = 0;
    for (std::size_t i = 4; i-- > 0;) size = size << 8 | static_cast<unsigned char>(text[i]);
    nlohmann::json message = nlohmann::json::parse(text.substr(4, size));
    message["jpeg_bytes"] = text.size() - 4 - size;
    return message;
  }
  std::uint64_t hear_serial() { return hear()["state"]["serial"]; }

 private:
  websocket::stream<beast::tcp_stream> socket_;
};

TEST_F(LiveServerTest, ThePageLiesInTheProgram) {
  for (const char* file : {"", "live.css", "live.js", "calibrate.js", "room.js", "chart.js"})
    EXPECT_THAT(get("/" + std::string(file), host), StartsWith("HTTP/1.1 200")) << file;
  EXPECT_THAT(get("/", host), HasSubstr("id=\"picture\""));
  EXPECT_THAT(get("/", "localhost:" + std::to_string(port)), StartsWith("HTTP/1.1 200"));
}

TEST_F(LiveServerTest, AnotherHostIsRefused) {
  for (const std::string& other :
       {std::string("evil.example"), "evil.example:" + std::to_string(port), std::string("127.0.0.1"),
        "192.168.0.1:" + std::to_string(port), std::string()})
    EXPECT_THAT(get("/", other), StartsWith("HTTP/1.1 403")) << other;
}

TEST_F(LiveServerTest, AnotherOriginIsRefused) {
  EXPECT_THAT(upgrade("Origin: http://evil.example\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(upgrade("Origin: null\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(upgrade("Origin: http://" + host + "\r\n"), StartsWith("HTTP/1.1 101"));
  EXPECT_THAT(upgrade(""), StartsWith("HTTP/1.1 101"));
}

TEST_F(LiveServerTest, NoPathLeadsToAFile) {
  for (const char* target :
       {"/../../../../etc/passwd", "/..%2f..%2fetc/passwd", "//etc/passwd", "/./live.js", "/live.js/",
        "/index.html", "/page/../live.css", "/%00", "/favicon.ico", "*", "xlive.js", "http://x/live.js"}) {
    const std::string said = get(target, host);
    EXPECT_THAT(said, Not(HasSubstr("root:"))) << target;
    EXPECT_THAT(said, Not(StartsWith("HTTP/1.1 200"))) << target;
  }
}

TEST_F(LiveServerTest, WhatIsTooLargeIsCutOff) {
  EXPECT_THAT(get("/", host, "X: " + std::string(20000, 'x') + "\r\n"), Not(HasSubstr("200 OK")));
  EXPECT_THAT(get("/", host, "Content-Length: 100000\r\n"), Not(HasSubstr("200 OK")));
  PageClient client(io, port);
  EXPECT_ANY_THROW({
    client.say({{"do", std::string(3 << 20, 'x')}});
    client.hear();
  });
  EXPECT_THAT(get("/", host), HasSubstr("200 OK"));
}

TEST_F(LiveServerTest, WhatIsNoMessageEndsItsClientAlone) {
  nlohmann::json deep = 7;
  for (int i = 0; i < 100; ++i) deep = nlohmann::json::array({std::move(deep)});
  for (const nlohmann::json& what :
       std::initializer_list<nlohmann::json>{nullptr,
                                             7,
                                             nlohmann::json::array({"look"}),
                                             {{"do", 3}},
                                             {{"do", "look"}, {"view", 1}},
                                             {{"do", "touch"}, {"touch", deep}}}) {
    PageClient client(io, port);
    EXPECT_ANY_THROW({
      client.say(what);
      client.hear();
    }) << what;
  }
  EXPECT_THAT(get("/", host), HasSubstr("200 OK"));
}

TEST_F(LiveServerTest, SlowRequestsAreNotWaitedFor) {
  std::vector<tcp::socket> slow;
  for (int i = 0; i < 20; ++i) {
    slow.push_back(connected());
    asio::write(slow.back(), asio::buffer(std::string("GET / HTTP/1.1\r\nHo")));
  }
  EXPECT_THAT(get("/", host), HasSubstr("200 OK"));
  for (tcp::socket& socket : slow) EXPECT_EQ(rest(socket), "");
}

TEST_F(LiveServerTest, NothingIsSentUnlessItIsLookedAt) {
  PageClient client(io, port);
  publish();
  client.say({{"do", "look"}, {"view", "picture"}});
  const nlohmann::json first = client.hear();
  EXPECT_EQ(first["view"], "picture");
  EXPECT_GT(first["jpeg_bytes"], 0);
  EXPECT_TRUE(exchange.is_looked_at("picture"));
  EXPECT_FALSE(exchange.is_looked_at("candidates"));
  client.say({{"do", "look"}, {"view", "no such"}});
  EXPECT_EQ(client.hear()["jpeg_bytes"], 0);
}

TEST_F(LiveServerTest, StalledClientsHoldNobodyUpAndGetTheNewestInTheEnd) {
  std::vector<std::unique_ptr<PageClient>> clients;
  for (int i = 0; i < 8; ++i) {
    clients.push_back(std::make_unique<PageClient>(io, port));
    clients.back()->say({{"do", "look"}, {"view", "picture"}});
  }
  const std::uint64_t first = publish();
  for (const auto& client : clients) EXPECT_EQ(client->hear_serial(), first);
  for (int round = 0; round < 50; ++round) {
    const std::uint64_t serial = publish();
    for (std::size_t i = 2; i < clients.size(); ++i) {  // the first two neither paint nor read
      clients[i]->say({{"do", "painted"}});
      EXPECT_EQ(clients[i]->hear_serial(), serial);
    }
  }
  for (std::size_t i = 0; i < 2; ++i) {
    clients[i]->say({{"do", "painted"}});
    EXPECT_EQ(clients[i]->hear_serial(), first + 50) << "nothing in between was kept for it";
  }
}

TEST_F(LiveServerTest, TheStreamIsTheNewestLine) {
  const auto say = [&](const std::string& line) {
    exchange.publish({{"kind", "test"}}, std::chrono::steady_clock::now(), grey_picture, line);
  };
  say("first\n");
  PageClient program(io, port, "/stream");
  while (!exchange.is_looked_at(stream_view)) std::this_thread::sleep_for(1ms);
  say("second\n");
  EXPECT_EQ(program.hear_text(), "second\n");
  publish();  // without a line
  say("third\n");
  EXPECT_EQ(program.hear_text(), "third\n");
  EXPECT_ANY_THROW({
    program.say({{"do", "undo"}});
    program.hear_text();
  });
  EXPECT_TRUE(exchange.next_commands().empty());
  EXPECT_THAT(get("/stream", host), StartsWith("HTTP/1.1 404"));
}

TEST_F(LiveServerTest, APictureThatCannotBeDrawnIsSaidToBeSo) {
  PageClient client(io, port);
  client.say({{"do", "look"}, {"view", "picture"}});
  exchange.publish({{"kind", "test"}}, std::chrono::steady_clock::now(),
                   [](const std::string&) -> cv::Mat { throw std::runtime_error("no ink"); });
  const nlohmann::json without = client.hear();
  EXPECT_EQ(without["fault"], "no ink");
  EXPECT_EQ(without["jpeg_bytes"], 0);
  publish();
  client.say({{"do", "painted"}});
  const nlohmann::json next = client.hear();
  EXPECT_EQ(next["fault"], "");
  EXPECT_GT(next["jpeg_bytes"], 0);
}

TEST_F(LiveServerTest, ClientsComeAndGo) {
  for (int i = 0; i < 200; ++i) {
    PageClient client(io, port);
    client.say({{"do", "look"}, {"view", "picture"}});
    publish();
    if (i % 2 == 0) client.hear();
  }
  EXPECT_THAT(get("/", host), HasSubstr("200 OK"));
}

TEST_F(LiveServerTest, CommandsComeInAndTheirAnswersGoOut) {
  PageClient client(io, port);
  client.say({{"do", "teach"}, {"u_px", 3}});
  const LiveCommand command = command_in(exchange);
  EXPECT_EQ(command.what["u_px"], 3);
  command.answer({{"answer", "teach"}});
  EXPECT_EQ(client.hear()["answer"], "teach");
  for (std::size_t i = 0; i <= LiveExchange::most_waiting; ++i) client.say({{"do", "undo"}});
  EXPECT_TRUE(client.hear().contains("refused")) << "what nobody takes is not piled up";
}

TEST_F(LiveServerTest, AnAnswerMayComeAfterItsServerHasGone) {
  LiveCommand command;
  {
    LiveExchange others;
    const LiveServer short_lived({"127.0.0.1", 0}, others);
    const std::string& url = short_lived.url();
    PageClient client(io, static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1))));
    client.say({{"do", "keep"}});
    command = command_in(others);
  }
  for (int i = 0; i < 100; ++i) command.answer({{"answer", "keep"}});
}

/// A few bytes of a request or a message changed, left out or doubled.
std::string broken(std::string text, RandomEngine& engine) {
  for (std::uint32_t changes = 1 + uniform_index(engine, 4); changes > 0 && !text.empty(); --changes) {
    const std::size_t at = uniform_index(engine, static_cast<std::uint32_t>(text.size()));
    const std::uint32_t how = uniform_index(engine, 3);
    if (how == 0) text[at] = static_cast<char>(uniform_index(engine, 256));
    if (how == 1) text.erase(at, 1 + uniform_index(engine, 9));
    if (how == 2) text.insert(at, text.substr(at, 1 + uniform_index(engine, 30)));
  }
  return text;
}

TEST_F(LiveServerTest, BrokenRequestsAndMessagesHarmNobody) {
  RandomEngine engine = random_stream(5, "broken");
  const std::string page = "GET / HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n";
  const std::string socket = "GET /socket HTTP/1.1\r\nHost: " + host +
                             "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                             "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
  const std::string look = R"({"do":"look","view":"picture"})";
  const std::string message =
      std::string("\x81") + static_cast<char>(0x80 | look.size()) + std::string(4, '\0') + look;
  publish();
  for (int i = 0; i < 1000; ++i) {
    tcp::socket client = connected();
    boost::system::error_code closed;
    const std::string said = i % 3 == 0   ? broken(page, engine)
                             : i % 3 == 1 ? broken(socket, engine) + message
                                          : socket + broken(message + message, engine);
    asio::write(client, asio::buffer(said), closed);
    client.shutdown(tcp::socket::shutdown_send, closed);
    rest(client);
  }
  EXPECT_THAT(get("/", host), HasSubstr("200 OK"));
  PageClient client(io, port);
  client.say({{"do", "look"}, {"view", "picture"}});
  EXPECT_GT(client.hear()["jpeg_bytes"], 0);
}

class LiveServerForOthersTest : public LiveServerTest {
 protected:
  LiveServerForOthersTest() : LiveServerTest("0.0.0.0") {}
};

TEST_F(LiveServerForOthersTest, IsReachedByItsSecretAlone) {
  ASSERT_EQ(path.size(), 34u);
  EXPECT_THAT(get(path, host), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(upgrade("Origin: http://" + host + "\r\n"), StartsWith("HTTP/1.1 101"));
  std::string wrong = path;
  wrong[1] = wrong[1] == '0' ? '1' : '0';
  for (const std::string& other :
       {std::string("/"), std::string("/socket"), std::string("/live.js"), wrong, path.substr(0, 33)})
    EXPECT_THAT(get(other, host), StartsWith("HTTP/1.1 404")) << other;
  EXPECT_THAT(get(path, "evil.example:" + std::to_string(port)), StartsWith("HTTP/1.1 403"));
}

TEST(LiveServerStart, SaysWhyItCannotListen) {
  LiveExchange exchange;
  EXPECT_THROW(LiveServer({"nowhere", 0}, exchange), InputError);
  EXPECT_THROW(LiveServer({"192.0.2.1", 0}, exchange), InputError);
}

}  // namespace
}  // namespace ballservo
