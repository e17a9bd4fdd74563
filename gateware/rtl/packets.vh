// The single table of packets, answers and figures shared by both ends. The test in tests/device/gateware compares it
// with the table in Rust; doc/protocol.md explains it.
`ifndef PACKETS_VH
`define PACKETS_VH

`define PROTOCOL_VERSION 8'd2
`define GATEWARE_VERSION 8'd3

// Packets to the device, and their payload bytes.
`define TYPE_INFO 8'h01
`define TYPE_STATUS 8'h02
`define TYPE_ENABLE 8'h03
`define TYPE_MUTE 8'h04
`define TYPE_BAUD 8'h05
`define TYPE_RESET 8'h06
`define TYPE_DIGEST 8'h07
`define TYPE_PHASES 8'h10
`define TYPE_FRAME 8'h11
`define TYPE_PLAY 8'h20
`define TYPE_STOP 8'h21
`define TYPE_ENVELOPE 8'h30
`define TYPE_RATE 8'h31
`define TYPE_SILENCER 8'h32
`define TYPE_WIDTHS 8'h33
`define TYPE_CALIBRATION 8'h34

`define PAYLOAD_INFO 10'd0
`define PAYLOAD_STATUS 10'd0
`define PAYLOAD_ENABLE 10'd0
`define PAYLOAD_MUTE 10'd0
`define PAYLOAD_BAUD 10'd0
`define PAYLOAD_RESET 10'd0
`define PAYLOAD_DIGEST 10'd0
`define PAYLOAD_PHASES 10'd256
`define PAYLOAD_FRAME 10'd512
`define PAYLOAD_PLAY 10'd3
`define PAYLOAD_STOP 10'd0
`define PAYLOAD_ENVELOPE 10'd256
`define PAYLOAD_RATE 10'd0
`define PAYLOAD_SILENCER 10'd0
`define PAYLOAD_WIDTHS 10'd256
`define PAYLOAD_CALIBRATION 10'd512

// Answers: the packet's type with this bit inverted; for a spoiled packet, this bit alone.
`define TYPE_ANSWER 8'h80

// Results.
`define RESULT_OK 8'd0
`define RESULT_CRC 8'd1
`define RESULT_LENGTH 8'd2
`define RESULT_BUSY 8'd3
`define RESULT_UNKNOWN 8'd4
`define RESULT_ARGUMENT 8'd5
`define RESULT_STATE 8'd6

// Bits of the flags of an answer.
`define FLAG_ENABLED 0
`define FLAG_TRIPPED 1
`define FLAG_PLAYING 2
`define FLAG_EMERGENCY 3
`define FLAG_SOUNDING 4
`define FLAG_WAITING 5
`define FLAG_STOPPED 6
`define FLAG_FOLLOWS 7

// The address accepted by all devices and answered by none.
`define BROADCAST 8'hFF
// When a PLAY is taken: at the next period, at the end of the running loop, at a period marked by the leader, or after a
// rising edge of the trigger input.
`define WHEN_AT_ONCE 2'd0
`define WHEN_AFTER_LOOP 2'd1
`define WHEN_IN_STEP 2'd2
`define WHEN_AT_TRIGGER 2'd3
// Tables of DIGEST.
`define DIGEST_SLOT 2'd0
`define DIGEST_ENVELOPE 2'd1
`define DIGEST_WIDTHS 2'd2
`define DIGEST_CALIBRATION 2'd3

// ENABLE without a watchdog needs this as its third argument.
`define CONFIRM 8'h5A
// Log2 of the periods without a good packet after which the line reverts to its first rate.
`define FALLBACK_BITS 15
// Limits of BAUD's increment.
`define SLOWEST_INCREMENT 16'd64
`define FASTEST_INCREMENT 16'd16384

// Largest changes per period after power-up, in 1/256 of a unit, and the smallest mute step.
`define FIRST_PHASE_STEP 16'h0300
`define FIRST_AMPLITUDE_STEP 16'h0600
`define MUTE_STEP 16'h0100

// Pulse widths in 1/256 period after power-up, round(256/pi * asin(a/255)), amplitude 255 first.
`define FIRST_WIDTHS 2048'h8079767372706e6d6c6a69686766656463626160605f5e5d5c5c5b5a595958575756555554545352525151504f4f4e4e4d4d4c4c4b4b4a4949484847474646454545444443434242414140403f3f3f3e3e3d3d3c3c3b3b3b3a3a393939383837373636363535343434333332323231313130302f2f2f2e2e2d2d2d2c2c2c2b2b2a2a2a292929282828272726262625252524242423232322222221212020201f1f1f1e1e1e1d1d1d1c1c1c1b1b1b1a1a1a1919191818181717171616161515151414141313131212121111111010100f0f0f0e0e0e0d0d0d0d0c0c0c0b0b0b0a0a0a090909080808070707060606050505040404040303030202020101010000

// The widest pulse.
`define WIDEST 8'd128

`endif
