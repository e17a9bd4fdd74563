// The device with what the test bench wants to see of its inside: when a period ends, and what passes through the gate.
`default_nettype none

module watched #(
    parameter PHASE_BITS = 7
) (
    input  wire        clk,
    input  wire        reset,
    input  wire        rxd,
    output wire        txd,
    input  wire        estop_n,
    output wire [31:0] data,
    output wire        shift,
    output wire        latch,
    output wire        oe_n,
    output wire        sync,
    output wire        led_on,
    output wire        led_tripped,
    output wire        led_packet,
    output wire        period_ends,
    output wire        applied,
    output wire [7:0]  applied_type,
    output wire [7:0]  applied_seq,
    output wire [7:0]  applied_result
);
    device #(.PHASE_BITS(PHASE_BITS)) device (
        .clk(clk), .reset(reset), .rxd(rxd), .txd(txd), .estop_n(estop_n),
        .data(data), .shift(shift), .latch(latch), .oe_n(oe_n), .sync(sync),
        .led_on(led_on), .led_tripped(led_tripped), .led_packet(led_packet)
    );

    assign period_ends = device.last;
    assign applied = device.packet_done;
    assign applied_type = device.packet_type;
    assign applied_seq = device.packet_seq;
    assign applied_result = device.result;
endmodule

`default_nettype wire
