// The frame store: 2^SLOT_BITS slots of 256 phases and amplitudes, which can be written separately.
`default_nettype none

module frames #(
    parameter SLOT_BITS = 6
) (
    input  wire                 clk,
    input  wire                 write_phase,
    input  wire                 write_amplitude,
    input  wire [SLOT_BITS+7:0] write_address,      // slot, channel
    input  wire [7:0]           phase_written,
    input  wire [7:0]           amplitude_written,
    input  wire [SLOT_BITS+7:0] read_address,
    output wire [7:0]           phase,              // a clock later
    output wire [7:0]           amplitude
);
    ram #(.ADDRESS_BITS(SLOT_BITS + 8), .WIDTH(8)) phases (
        .clk(clk),
        .write(write_phase),
        .write_address(write_address),
        .write_data(phase_written),
        .read_address(read_address),
        .read_data(phase)
    );
    ram #(.ADDRESS_BITS(SLOT_BITS + 8), .WIDTH(8)) amplitudes (
        .clk(clk),
        .write(write_amplitude),
        .write_address(write_address),
        .write_data(amplitude_written),
        .read_address(read_address),
        .read_data(amplitude)
    );
endmodule

`default_nettype wire
