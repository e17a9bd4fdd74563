// The pulses of the eight channels of one shift register, in two banks, one written while the other is played, and
// the comparator that turns them into bits, three clocks after `read_address`.
`default_nettype none

module lane #(
    parameter PHASE_BITS = 7
) (
    input  wire                    clk,
    input  wire                    write,
    input  wire [3:0]              write_address,   // bank, channel
    input  wire [2*PHASE_BITS-1:0] write_pulse,     // rise, width
    input  wire [3:0]              read_address,
    input  wire [PHASE_BITS-1:0]   level,           // a clock after `read_address`
    output reg                     high
);
    reg [2*PHASE_BITS-1:0] pulses [0:15];
    reg [PHASE_BITS-1:0]   rise, width, width_held, since;

    integer i;
    initial for (i = 0; i < 16; i = i + 1) pulses[i] = 0;

    always @(posedge clk) begin
        if (write) pulses[write_address] <= write_pulse;
        {rise, width} <= pulses[read_address];
        since <= level - rise;
        width_held <= width;
        high <= since < width_held;
    end

`ifdef FORMAL
    always @(posedge clk) if (write) assert (write_address[3] != read_address[3]);
`endif
endmodule

`default_nettype wire
