// Amplitude modulation: an oscillator of 24 bits that steps once per period walks through a table of 256 values.
`default_nettype none

module modulation (
    input  wire        clk,
    input  wire        reset,           // or RESET
    input  wire        boundary,
    input  wire        set,             // take the step, from the table's start if `set_start`
    input  wire [23:0] set_step,
    input  wire        set_start,
    input  wire        write,
    input  wire [7:0]  write_address,
    input  wire [7:0]  write_data,
    input  wire        digesting,       // read the table at `digest_address`
    input  wire [7:0]  digest_address,
    output wire [7:0]  envelope,        // two clocks after the boundary
    output reg         begins           // a clock after the boundary: the table begins
);
    reg [23:0] angle, step;
    reg        start;
    wire [24:0] next = {1'b0, angle} + {1'b0, step};

    ram values (
        .clk(clk),
        .write(write),
        .write_address(write_address),
        .write_data(write_data),
        .read_address(digesting ? digest_address : angle[23:16]),
        .read_data(envelope)
    );

    always @(posedge clk) begin
        if (boundary) begin
            angle <= start ? 24'd0 : next[23:0];
            begins <= start || next[24];
            start <= 1'b0;
        end
        if (set) begin
            step <= set_step;
            if (set_start) start <= 1'b1;
        end

        if (reset) begin
            angle <= 24'd0;
            step <= 24'd0;
            start <= 1'b0;
            begins <= 1'b0;
        end
    end
endmodule

`default_nettype wire
