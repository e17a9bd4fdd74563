// modulation: the table's values at the oscillator's rate, or at a digest's address.
`include "check.vh"
module modulation_bench;
    `include "bench.vh"
    reg         reset = 1, boundary = 0, set = 0, start = 0, write = 0;
    reg  [23:0] step = 0;
    reg  [7:0]  address = 0, value = 0;
    reg         digesting = 0;
    reg  [7:0]  digest_address = 0;
    wire [7:0]  envelope;
    wire        begins;
    modulation modulation (
        .clk(clk), .reset(reset), .boundary(boundary), .set(set), .set_step(step), .set_start(start),
        .digesting(digesting), .digest_address(digest_address), .write(write), .write_address(address), .write_data(value), .envelope(envelope), .begins(begins)
    );

    reg [23:0] angle;
    reg first = 0;
    task period(input [7:0] expected);
        begin
            boundary = 1;
            @(negedge clk) boundary = 0;
            @(negedge clk) `CHECK("the table begins", begins, first || modulation.angle < modulation.step)
            first = 0;
            @(negedge clk) `CHECK("the envelope", envelope, expected)
        end
    endtask
    task rate(input [23:0] to, input from_start);
        begin
            {step, start, set} = {to, from_start, 1'b1};
            if (from_start) first = 1;
            @(negedge clk) set = 0;
        end
    endtask

    integer i;
    initial begin
        repeat (2) @(negedge clk);
        reset = 0;
        write = 1;
        for (i = 0; i < 256; i = i + 1) begin
            {address, value} = {i[7:0], ~i[7:0] ^ 8'h5A};
            @(negedge clk);
        end
        write = 0;
        rate(24'd83886, 1);     // 200 Hz at 40 kHz
        angle = 0;
        for (i = 0; i < 1000; i = i + 1) begin
            period(~angle[23:16] ^ 8'h5A);
            angle = angle + 24'd83886;
        end
        // A new step without a restart continues from the current angle; the old angle is one step behind.
        rate(24'h800001, 0);
        angle = angle - 24'd83886;
        for (i = 0; i < 100; i = i + 1) begin
            angle = angle + 24'h800001;
            period(~angle[23:16] ^ 8'h5A);
        end
        digesting = 1;
        for (i = 0; i < 256; i = i + 1) begin
            digest_address = i;
            @(negedge clk) `CHECK("what a digest reads", envelope, ~i[7:0] ^ 8'h5A)
        end
        digesting = 0;
        angle = angle + 24'h800001;
        period(~angle[23:16] ^ 8'h5A);
        `END
    end
endmodule
