// The device with internal signals for the test bench: the end of a period, packets passing the gate, and whether it
// accepts packets and follows a leader.
`default_nettype none

module watched #(
    parameter PHASE_BITS = 7,
    parameter SLOT_BITS = 6
) (
    input  wire        clk,
    input  wire        reset,
    input  wire        rxd,
    output wire        txd,
    /* verilator lint_off SYNCASYNCNET */
    input  wire        estop_n,
    /* verilator lint_on SYNCASYNCNET */
    input  wire        sync_in,
    input  wire        trigger_in,
    input  wire [2:0]  address,
    output wire [31:0] data,
    output wire        shift,
    output wire        latch,
    output wire        oe_n,
    output wire        sync,
    output wire        trigger,
    output wire        led_on,
    output wire        led_tripped,
    output wire        led_packet,
    output wire        awake,
    output wire        follows,
    output wire        period_ends,
    output wire        applied,
    output wire [7:0]  applied_type,
    output wire [7:0]  applied_seq,
    output wire [7:0]  applied_result
);
    device #(.PHASE_BITS(PHASE_BITS), .SLOT_BITS(SLOT_BITS)) device (
        .clk(clk), .reset(reset), .rxd(rxd), .txd(txd), .estop_n(estop_n), .sync_in(sync_in), .trigger_in(trigger_in),
        .address(address), .data(data), .shift(shift), .latch(latch), .oe_n(oe_n), .sync(sync), .trigger(trigger),
        .led_on(led_on), .led_tripped(led_tripped), .led_packet(led_packet)
    );

    assign awake = !device.asleep;
    assign follows = device.follows;
    assign period_ends = device.last;
    assign applied = device.packet_done;
    assign applied_type = device.packet_type;
    assign applied_seq = device.packet_seq;
    assign applied_result = device.result;
endmodule

`default_nettype wire
