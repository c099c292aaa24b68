"""What comes over the network: who may ask, in which words, and what is answered."""
