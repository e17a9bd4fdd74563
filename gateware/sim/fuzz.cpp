// Sends random packets through the Verilated receiver, a quarter of them damaged: fuzz [PACKETS] [SEED].
//
// No whole packet may be lost or changed by damage to its neighbours, and no damaged one may be accepted as another;
// the CRC's 32 bits miss one of 4 000 000 000. Packets to other devices are ignored.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <vector>

#include "Vreceiver.h"
#include "verilated.h"

namespace {

using Bytes = std::vector<uint8_t>;

uint32_t crc(const Bytes &body) {
    uint32_t value = 0xFFFFFFFF;
    for (const uint8_t byte : body) {
        value ^= byte;
        for (int bit = 0; bit < 8; ++bit) value = value & 1 ? value >> 1 ^ 0xEDB88320 : value >> 1;
    }
    return ~value;
}

// COBS between two delimiters.
Bytes framed(Bytes body) {
    const uint32_t check = crc(body);
    for (int i = 0; i < 4; ++i) body.push_back(uint8_t(check >> (8 * i)));
    Bytes line{0};
    size_t code = line.size();
    line.push_back(1);
    for (size_t i = 0; i < body.size(); ++i) {
        if (body[i] != 0) {
            line.push_back(body[i]);
            ++line[code];
        }
        if (body[i] == 0 || (line[code] == 0xFF && i + 1 < body.size())) {
            code = line.size();
            line.push_back(1);
        }
    }
    line.push_back(0);
    return line;
}

constexpr uint8_t ADDRESS = 5;

class Dice {
public:
    explicit Dice(uint64_t seed) : engine(seed) {}
    // From 0 to limit - 1.
    unsigned below(unsigned limit) { return unsigned(engine() % limit); }
    uint8_t byte() { return uint8_t(engine() >> 40); }

    // A random packet before its CRC. Some have many zeros, which exercise COBS.
    Bytes body() {
        const unsigned kind = below(32);
        const unsigned payload = kind == 0 ? 512 : kind < 3 ? 256 : kind < 8 ? below(64) : below(12);
        const unsigned zeros = below(4) == 0 ? 3 : 64;
        Bytes body(7 + payload);
        for (auto &one : body) one = below(zeros) == 0 ? uint8_t(0) : byte();
        body[0] &= 0x7F;
        const unsigned address = below(16);
        body[1] = address == 0 ? 0xFF : address == 1 ? 6 : ADDRESS;
        return body;
    }

    // Damages a line, except its first delimiter, which belongs to the packet before.
    void damage(Bytes &line) {
        const auto at = line.begin() + 1 + below(unsigned(line.size()) - 1);
        switch (below(5)) {
            case 0: line.erase(at); break;
            case 1: *at ^= uint8_t(1 << below(8)); break;
            case 2: line.insert(at, byte()); break;
            case 3: {
                const auto end = std::min(at + 1 + below(24), line.end());
                std::generate(at, end, [&] { return byte(); });
                break;
            }
            default: line.erase(at, std::min(at + 1 + below(24), line.end()));
        }
    }

private:
    std::mt19937_64 engine;
};

class Receiver {
public:
    Receiver() {
        receiver->address = ADDRESS;
        receiver->reset = 1;
        clock();
        receiver->reset = 0;
        clock();
    }

    void put(uint8_t byte) {
        receiver->valid = 1;
        receiver->data = byte;
        clock();
        receiver->valid = 0;
    }
    void no_byte() {
        receiver->framing = 1;
        clock();
        receiver->framing = 0;
    }

    // Takes the waiting packets, without their CRC.
    std::vector<Bytes> take() {
        clock();
        std::vector<Bytes> packets;
        while (receiver->ready) {
            Bytes body{receiver->packet_type, uint8_t(receiver->broadcast ? 0xFF : ADDRESS), receiver->packet_seq};
            for (int i = 0; i < 4; ++i) body.push_back(uint8_t(receiver->arguments >> (8 * i)));
            for (unsigned i = 0; i < receiver->length; ++i) {
                receiver->read_address = uint16_t(i & 0x1FF);
                clock();
                body.push_back(receiver->read_data);
            }
            receiver->done = 1;
            clock();
            receiver->done = 0;
            packets.push_back(body);
        }
        return packets;
    }

private:
    void clock() {
        receiver->clk = 1;
        receiver->eval();
        receiver->clk = 0;
        receiver->eval();
    }

    std::unique_ptr<Vreceiver> receiver = std::make_unique<Vreceiver>();
};

}  // namespace

int main(int count, char **arguments) {
    const long packets = count > 1 ? std::atol(arguments[1]) : 200000;
    Dice dice(count > 2 ? std::strtoull(arguments[2], nullptr, 10) : 1);
    Receiver receiver;
    long whole = 0, damaged = 0, wrong = 0;
    Bytes before;
    for (long i = 0; i < packets; ++i) {
        const Bytes body = dice.body();
        const Bytes line = framed(body);
        Bytes sent = line;
        bool framing = false;
        if (dice.below(4) == 0) {
            framing = dice.below(6) == 0;
            if (!framing) dice.damage(sent);
        }
        const size_t lost = framing ? 1 + dice.below(unsigned(sent.size()) - 1) : 0;
        for (size_t at = 0; at < sent.size(); ++at) {
            if (framing && at == lost) receiver.no_byte();
            receiver.put(sent[at]);
        }

        const auto taken = receiver.take();
        const bool is_whole = !framing && sent == line;
        ++(is_whole ? whole : damaged);
        const bool for_another = body[1] == 6;
        if (is_whole && for_another && !taken.empty() && taken.back() == body) {
            std::fprintf(stderr, "packet %ld for another device was accepted\n", i);
            return 1;
        }
        if (is_whole && !for_another && (taken.empty() || taken.back() != body)) {
            std::fprintf(stderr, "whole packet %ld was lost or changed\n", i);
            return 1;
        }
        if (framing && !taken.empty() && taken.back() == body) {
            std::fprintf(stderr, "packet %ld was accepted despite a framing error\n", i);
            return 1;
        }
        // A packet that lost only its delimiter is delivered with the next one.
        for (const Bytes &one : taken) wrong += one != body && one != before;
        before = body;
    }
    std::printf("%ld whole packets, none lost; of %ld damaged ones, %ld accepted as others\n", whole, damaged, wrong);
    return wrong == 0 ? 0 : 1;
}
