"""Plants with what data sheets leave out: friction of the load, cogging, wear, another load, shocks."""
