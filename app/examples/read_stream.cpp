// Reads what `ballservo track ... --stream` or `ballservo live ... --stream` sends, and says where the balls
// are, as read_stream.py.
//
//     g++ -std=c++17 app/examples/read_stream.cpp -o read_stream         # nlohmann-json3-dev
//     ballservo track camera:0 --colors my.colors --stream - | ./read_stream
//     ./read_stream 9000 &                                               # for --stream udp:127.0.0.1:9000
#include <netinet/in.h>
#include <sys/socket.h>

#include <cmath>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

void tell(const std::string& line) {
  const auto picture = nlohmann::json::parse(line);
  for (const auto& ball : picture["balls"]) {
    std::printf("%.3f s: %s %ld (%s) at", picture["time_s"].get<double>(),
                ball["class"].get<std::string>().c_str(), ball["track_id"].get<long>(),
                ball["state"].get<std::string>().c_str());
    if (ball["p_m"].is_null()) {  // --camera and --diameter give metres
      std::printf(" %.1f, %.1f px\n", ball["outline_px"][0].get<double>(),
                  ball["outline_px"][1].get<double>());
      continue;
    }
    for (std::size_t i = 0; i < 3; ++i)
      std::printf("%s %.3f +- %.3f", i == 0 ? "" : ",", ball["p_m"][i].get<double>(),
                  std::sqrt(ball["covariance_m2"][i][i].get<double>()));
    std::printf(" m\n");
  }
  std::fflush(stdout);
}

int main(int count, char** arguments) {
  std::string line;
  if (count < 2) {
    while (std::getline(std::cin, line)) tell(line);
    return 0;
  }
  const int receiver = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_port = htons(static_cast<in_port_t>(std::stoi(arguments[1])));
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (bind(receiver, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0)
    return std::perror("bind"), 1;
  for (;;) {
    line.resize(65535);
    const ssize_t bytes = recv(receiver, line.data(), line.size(), 0);
    if (bytes < 0) return std::perror("recv"), 1;
    line.resize(static_cast<std::size_t>(bytes));
    tell(line);
  }
}
