// SPDX-License-Identifier: Apache-2.0
#include "drivers/net/udp_socket.hpp"

#include <fcntl.h>
#include <array>

#include <gtest/gtest.h>

namespace srd {
namespace {

using std::chrono::seconds;

Address address_of(const char* text) {
  const auto parsed = Address::parse(text, "test");
  EXPECT_TRUE(parsed.ok()) << text;
  return parsed.ok() ? *parsed : Address{};
}

TEST(Address, ReadsBothFamiliesAndSaysThemBack) {
  for (const char* text : {"127.0.0.1:47810", "[::1]:47810", "10.1.2.3:1", "0.0.0.0:0"})
    EXPECT_EQ(address_of(text).text(), text);
  EXPECT_EQ(address_of("127.0.0.1:47810").port(), 47810);
  EXPECT_TRUE(address_of("127.3.2.1:1").is_loopback());
  EXPECT_TRUE(address_of("[::1]:1").is_loopback());
  EXPECT_FALSE(address_of("10.0.0.1:1").is_loopback());
  EXPECT_FALSE(address_of("0.0.0.0:1").is_loopback());
}

TEST(Address, SaysWhatIsWrong) {
  for (const char* text :
       {"", "127.0.0.1", "127.0.0.1:", ":47810", "127.0.0.1:70000", "127.0.0.1:-1", "127.0.0.1:80x", "::1:47810", "[]:1"}) {
    const auto parsed = Address::parse(text, "--bind");
    ASSERT_FALSE(parsed.ok()) << text;
    EXPECT_EQ(parsed.error().exit, Exit::kUsage) << text;
    EXPECT_EQ(parsed.error().where, "--bind");
  }
}

TEST(Address, KnowsNumbersFromNamesWithoutALookup) {
  for (const char* text : {"10.1.2.3:47810", "[::1]:47810"}) {
    const auto host = HostAndPort::parse(text, "test");
    ASSERT_TRUE(host.ok()) << text;
    const auto address = Address::numeric(*host);
    ASSERT_TRUE(address.has_value()) << text;
    EXPECT_EQ(address->text(), text);
  }
  const auto name = HostAndPort::parse("localhost:47810", "test");
  ASSERT_TRUE(name.ok());
  EXPECT_EQ(name->host, "localhost");
  EXPECT_EQ(name->port, 47810);
  EXPECT_FALSE(Address::numeric(*name).has_value());
}

TEST(UdpSocket, CarriesDatagramsBothWays) {
  for (const char* text : {"127.0.0.1:0", "[::1]:0"}) {
    auto host = UdpSocket::bind(address_of(text));
    if (!host && std::string_view(text).front() == '[') GTEST_SKIP() << "no IPv6 here: " << host.error().text();
    ASSERT_TRUE(host.ok());
    auto node = UdpSocket::connect(host->local());
    ASSERT_TRUE(node.ok());
    const std::array<std::uint8_t, 3> sent{1, 2, 3};
    EXPECT_EQ(node->send(sent), UdpSocket::Sent::kSent);
    std::array<std::uint8_t, 16> got{};
    Address from;
    ASSERT_EQ(host->receive(got, seconds(10), &from), 3);
    EXPECT_EQ(got[2], 3);
    EXPECT_TRUE(from == node->local());
    EXPECT_EQ(host->send_to(from, std::span(sent).first(2)), UdpSocket::Sent::kSent);
    EXPECT_EQ(node->receive(got, seconds(10)), 2);
    EXPECT_EQ(node->receive(got, std::chrono::milliseconds(1)), -1);
  }
}

TEST(UdpSocket, TellsTheSizeOfWhatDidNotFit) {
  auto host = UdpSocket::bind(address_of("127.0.0.1:0"));
  auto node = UdpSocket::connect(host->local());
  const std::array<std::uint8_t, 100> sent{};
  ASSERT_EQ(node->send(sent), UdpSocket::Sent::kSent);
  std::array<std::uint8_t, 10> got{};
  EXPECT_EQ(host->receive(got, seconds(10)), 100);
}

TEST(UdpSocket, OutlivesAPeerThatDoesNotListen) {
  const Address address = UdpSocket::bind(address_of("127.0.0.1:0"))->local();
  auto node = UdpSocket::connect(address);
  const std::array<std::uint8_t, 1> sent{};
  std::array<std::uint8_t, 1> got{};
  for (int i = 0; i < 10; ++i) {
    (void)node->send(sent);
    EXPECT_EQ(node->receive(got, std::chrono::milliseconds(1)), -1);
  }
  auto back = UdpSocket::bind(address);
  ASSERT_TRUE(back.ok());
  for (int i = 0; i < 3; ++i) (void)node->send(sent);  // the first may still report the refusal
  EXPECT_EQ(back->receive(got, seconds(10)), 1);
}

TEST(UdpSocket, ExplainsAnAddressInUse) {
  auto first = UdpSocket::bind(address_of("127.0.0.1:0"));
  const auto second = UdpSocket::bind(first->local());
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().exit, Exit::kNetwork);
  EXPECT_EQ(second.error().where, first->local().text());
  EXPECT_FALSE(UdpSocket::bind(address_of("192.0.2.1:0")).ok());
}

TEST(UniqueFd, ClosesWhatItOwns) {
  int number = -1;
  {
    UniqueFd fd(::open("/dev/null", O_RDONLY | O_CLOEXEC));
    number = fd.get();
    ASSERT_GE(number, 0);
    UniqueFd other(std::move(fd));
    EXPECT_FALSE(fd.valid());  // NOLINT: what moving leaves behind
    EXPECT_EQ(::fcntl(number, F_GETFD) & FD_CLOEXEC, FD_CLOEXEC);
  }
  EXPECT_EQ(::fcntl(number, F_GETFD), -1);
}

}  // namespace
}  // namespace srd
