"""Trees that distinguish people from what looks like them, fitted by ``python -m benchmarks.people.torso.training``."""

BIAS = -0.2808
"""Log odds without trees."""

SCALE = 0.00211505
"""Value of one unit of the leaves."""

FEATURES = """
F9ALU4*@|1Oa(0j69E$iQ3V(U7zGal^aK<IHU;AZ4*@;}PX!DCHU(1!Qw386Qw2`}PXX`%Qw386@B~u@@C2^{Qw1*pPy{al&jJtw?E&)uF9GiYPz
CP-4FgRC?g4}Z+XM;)umTMMD+G`LJq0`k6$McR`vfBeGzCxr@B)wl5CgmfO$06hQw386HU(1!QUx>xQw2~3<OC1_Jq1t&1_clSQw386Hw9A#5Cbp
)76noTQU&k=E&(wCQUp>3Faa6`FabaX9tE%gEd@&jQ3S684g(4W>H{DJ_5|+&_5|+&%>rivFaa<D@B$A3n*{L!G6WI<QUw?V?*Tmp90mOZPXST|H
w6v@Hw7&PHwC-|_XH^g`ULO-%>(@eX96?@Fa<RQ83k|v@C51rPX$p0j{pD#PXt#4E(KBrJOxn&g9P^k00lDyOa)B^wFATiZ~zws2L%QN83oS+&;l
C;umc7KPz6&2NdzqbO9XEK&H*t6Pz4MHP6TiO5(Q%fQw386Qw8t@P6bW{?*KFf_5?Qt5CixGbOh7@1_ciT4+Ihdt^&{l>;oJHPz9O+Py`7DngP%N
uL95lyadn!umK$fFalErQw28#Qw2{2j{@)jGzCiqHU$6$=mSj!i~z6#4+E|O{{;U8vIK7dQUx;wPzB8cGX+uvQUxvrQUx{z>jX3f3kB;0^aLFRtp
V=>8wCjhZ~;>VQw3866a_W~kOJ@kAqB1iSOiW2QUcZiGX$>!FaaP1&H?TKN(J}?DFsjk?gLZ=3I(<UF#(zcGyxF-4FVYjPyr1AoCI+Kj{<Q4P6Dh
1j{+?PF$MPl4+H1~5Cxe6^8`=@4FO98QU&=0Edo;oQw386@dP>rIt3I3Qw386Hw8Wg00k@nHw8-tP6eq0!vxd>jsqzLA_bfT@B&c+Edn?MoCH$^Q
w2^1K?P3*ZvsyRumZ3Gt^%6`umKqbE&>1rQU&e;F9GoZ^aSn!@c=CWEdenBF#$0Fs{s}T4+AX%F9PoYR|GWz`veOG^#mXV(*wo<_ymvwkOI&Fq6E
+Zj{>j(Qw0<SP6e+4@dU#JECo{qHw8BZHwDiC4Fm1~Qw0YFItA|n&;$Pj5CQlE5Ci@M{sa#LLj?c;&;rl`{sa&M&;hUm4FZq?FaqWRkOHFw&j1Po
BLz?e5d%*II|WY#kpeFT&jKw4?*Z=tE(DbX1qB%evIC9+7y|DD#{<s-&jKL@&jK$3O9ep!GzCiqPz6v0wgXZHEd^5rG6e7f4g(4W3I#9%q6Aj~F9
NazOae3lq694kr34uTG6JOpQ3VkN8U=9z5CIVbEdm$?001Ec?g1ACj{=bbwE?^YCk5{U(**AVyaZ1J)CBniPz9s`kpVsh?F8Wi^8`Evt^v;hQUy{
4ZUIjM3j(nM(E&UK9|h3?E(Om5F9gp4&jBd~IR%gct^#fWE&>q(`~(gJGzCxvPz6v0GzBjLNdpQ6PzC4#Py{~(`2?#12?g&0%LLB?PXjRoO$F`&4
g*pGtpW}MFadG_1qDzAC<ROeQUwJCuLDp5&;if^I0aAw&;n2bj{-CW_5?5iPzBWjP6hD*F##?C6b11CjRMR8ECo>oOa(6lHU%#PDFto<4gygEE&;
9q&H)htJq7RqkO7JUI0cmfFal8oOax2>Gz9wuMg(sGIR$P4_5n@-t^xM}5CKmD`vg$}`2?#0IsyOy?f_2#ItB0qg9MHN69qQ~HU&BbIt4lfF9A0N
Q3av|Z~$uokOC?MQ3SjM(E=R>Q3CM+3<E0#Mg<T9BLy%5LIoHF5Cc2~QUyE(uLDE{LIqF)?f{Pf83l|4Z2@lqHU*CXssT>|CIzYj4Ffy{4F$afQU
bjMj{*PyumR8ly#&w!j{z|O&;hUl`UEcp_5?}=kO1}slms0GZvq+xP6BcQG69nU5dlyEtpRWW5dj?qPysmwPz5#uO$0mz&jE`8u>!CG8wD@|Fan+
e4+ByKF9E^?GX+otPyrGF9t9c&)dB7S9tFGv69T0Kr37jLHv&=uuL5uZuK}+DuL4g3^#rd1FamA@4gwMajscDV(gN%N2?Z(y(*ytoF99(G1qChwk
ph|o5dzNv=m9PQIR!QaHU$<1YXlMjHU%vOPXZhT`ve^YQUhuMQ3XZ?4*<^sZvj;VFa%NsPXSK>PXbW^PXbZ}K?OAh9tA-KaRD0zj{!IZI0aG!7y~
i|H3c38`~<25{{;O6ECPxG@d45RHUu*Siv%qN(f}g`@B*y_FajY3a{)*N&;g|cECp`@F#^s5Py%lO90ddg83IrRkOPba008y`a{~DU^8xb#H3aqm
Nd>h8$pg~@F9J3NF9E&;y##IoBL&d{aRP1vq6Dh}Fa(PN`UG(T5&=^MYXJ}e_XJA<i2x7*Yyz+WQUa_2YywaMGXXII!UR198U?ik5dx?JPy!GGuL
Dp5^a8R0H3g3XEd|d2Ed?$EiUHvS=mZY~3j+@W4g*X9001!py9BfWI0exGlmd_e@d5DyO#%)B4g)X&&jL;aG6YlvE(A^lSOhEu00p`PCIq?!Py!D
F4FRtLkpk}l?*WkkI|c6nAqBkz8w2qI7X|JF001rpJOyz8_yjivr~)emBLzSOSpqc$@dRuEqXf?aAq8&&7zJ+vQ3db;x&#gba{;ab5d$p&@B+;Qa
05sM2?f#w!vrn`kO9yFOabr#@Bu*uFabOTMFl(s^#lY3K?N`YQUy{4Fa%ElPX&(xFal5nR0LE63j{3%R0IkIQUwwPQUy;1ngAaK76nWN`~*V<%mF
+F(*sfkJq3>fFae7Kj{*(@E&)>oNCgl9NCnIU5CJ#^Q3dY;j{waA?*Xp^Fa$CJmjZ4Ar35kpZUW5!q6E7H&jD)!_XLjulmRydQUxyoHwDlDiv&Fd
Py!GGBL%Pm5(7a6%mG3LIR!KYIR%gbIR!ffumW%bQU$UCQ3A~XoCL1}ECt#G69Uu&F9Fg6`2;)#KLZd05CaYa4g<>rOa-z7F$6;eF$4((83jBAjs
dU%M+F)MK?S1(Yy!{%tO2Y6Py)0BAq71J9tH3KJOwEMJO%0m`~(jH_XLgtU<8o^5&=vBQU!1V@dU8}HU+N&G6D|*asdwltpX1MCk6Wi1O@g4Zvs~
XIt4fdLIq9)^8`-;GX?hq9|g|=i2)A+j{z(NJq5A^vIKAf00nFTZUU_WE(IY4(g1S;a{>$lg9K6q@&rr;83l|2NdrCwIR!KYF9AvgIR$V5GzCop4
Fb&pP6CYq%>mE?`vmj^4FmfG`vmj^QU#?1Q36i{@Bs7yZURpPvI4RKF##0<ECs0qEdd?{7X=pu90eW)kOCY9{sjC4(*gbjOacT0)B@84Nd-*>O$A
8<%>+yZ9|a)=9R-d8gaj7_yacZSF#?YPy#%@hY5@-d3IeMEbOHJV`UEZkZ~;;U6$MHK4gt0T%mi=)E(P@jZveCeFao#%Dg|%?&;rl_a01W)&jZi_
K><(!uK{oYgaj@Dj{|c8y#zA?^8!!;&;pJE#RN(P4gpaDs{{K469rNQPys>(@BnoJj{%SZQU&h>Jq5M`Lj}(Q3I%NftpQO2ngkC4(E|4bE&`|m&j
D`%ivlkKtOSq({shng9|f}n4g=5uL<KtqZ~+$uvH}(bgaji6Q3W~#4+C%j^#c6>GzAF-QUT%wQ3F5)O$GJ@3k5?3Fapy92Lp-(Zvu}300mA0(gL^
w(gTkII|a`H76qaNjRHFb^8~d7kpYzgQ2`1AQUy~5GzBjKQU#CzZvwOd5d#ea69W+gEdmh&lLAi!O9WH|R0QM%Pz6f_Nd-9t)dV~RJOzdUPXti~4
FXRDjRMdDR0K~0y9Dk6_yqn0&H*j~E(06|kpj{I5d)C{+5rFnq6Dr2F#$~h@BuCXHwEkh?gH=v5d+QvwFFKA&;rl_Pyx^a&jQc^QU#&}3Ia?5G6C
%Y%mJ(cQ3S07OawFplLRUS3I$RHQU!YiI0erFumUy(tpcqA_yo-X%>niVQUx&rkpgZ383nQeP68|ePy$i~P68kWZvvDA008j>?*y&^ZvqDePXRLm
YXK_)D+2ihhypVJumMp8@B%OZECp}^^aCseQw1XhQ3Un`{{%t>#RNPBkODjfy#!YR@B}Xca{{vgvjKzz69uyY&;l+6`UF1(7zNA$j{(2~Qw1;q@B
oYiFado8umA=H5Cbm*u>wg2T?7CC7zHu{XaUawvH|e~9|ipcLIwN;It7#j6a?D@Qw8+|90gDVGzAs~vjOn|(E=|476Q=%6a_2+ZvyWEtpV=>`2_F
+@&PaeF#u2lPy*rvNd+(jQ3X{3kpdkBs{|7Q5&{hc9|fEQ8U-2!I0Y>QIR!=qK?M&1KLs}h)&UI#3I(hL`~)uq4gk*qBL%GlI0SYAasm_uRRj<MD
g|r-83kSfngpW+LIwB)I0aG#NCArkFad1=vH=MKlmQt9`UFn`qy)4C4gs<P9R&{oVFSwqYXi*$lLHC`NCnIUaRGJ#umN@faRKlFF#<pVMg`IWJO!
%(jsg+_F#>S`7zMHc5CP5taRL4W>;d5div&>uW&-U2t^%Y2Z36KDt^(}=?Ez5*asm$k5(2UTrvxqp90fiFwFGPgE&%`lwFEB$y#yQu+X9mU&;gnR
{R9aG`UL(2(F4l?`~+|UQUxCc5CMDy8U-E&`vf2b-vVC&7zM!si3C3d3<4_z&jL~cD+JF1PXtT^PX#OmPXurROa!?Ex&)5`t^&IRkpk`ktpsQRw*
tliEdp}^Q36Q?3j)>yO9GApIt8f%FakRT&;d3DHU%>U$pY^JF9I(D&;oM=>H^OJ69SV0Zvi0%kOGqe7zI-Wj{!IZqXY;AF9IzEQUx>xGzByRQU#0
zECf0QHU%~XIt6h63;{L;)C5WeN(Bi8QUi+vlmt!$&I3{eECo#kN(52`Q3Y%QQ3d)0RRR(NkN|N3t^scWaRLtlZvhGdAqD;f<OKKx`UF1#002`3Q
w8t@8U;B876OO_a02oKJq4-)>H%;9`vmp`vIIf|u>?*5`2-RKF$GcuZ~#yN<pfd%Py{alN&#&Fjsf-r^8s}N1O<-*kOR*F&jD@%XahY3Zvs38x&(
p(HU)12astu;F9M|mkpj{I@BvW;^8#-J@&fGwP6ST?lmfH?v;lMivjVUJa{^NZOaV0oE&);jK?M^9UjeWI{{(OW4FWI(3I!bn83h>y(gPg@5CfF~
3<AsoZ~;vM?E-KD^#uL|jRK7V%>m5;`~>|3Q3b66PXw(3v;_PF5CA&`F$9hP(EvLISOEY4Q3de=A_Y+e00lAw4+B#LQw4VcLIp7ZD*@C2Ck4v{uL
DR0%mhLOPy&zx2n8$!5Cba(5Cc*Lx&*oe_yqj~%mOk2%mPaV(*#BZO9d|kumU*+a{~4O8U<DY5CWV8y#xdW{{-m)(gLdlP6Yq}
"""
"""Feature of each decision, uint16, little-endian, as base85."""

LIMITS = """
2?P!V2o4Sa1p)yH0s{g72n7NV1_}ra1^@sK3J3rO00;~S01gQX3=Ihh0|5*V3kLuJ2nG-U0|Ed80|f>N2?+re5D5tf0tF8Q3j+lR0s;XJ3kU)R2@
VPm1PBQU5E2Or4g?Ab00|Ee2?7uR3J44a3;_%Y2@Vkq4h|9u0RjpE3l9Yd0006G3IqxW5d#4R00jyV0uTZP00#>Y0TKcO0SW;T3IYxe01pKO3JVA
f4h8}b5daDR3jhKD3jhEe2?h-S0s;;P3Iqxa91sKw3k(bo2?+uZ3k3lV4G9tk2?GiX2Lc2F2n_}Z1O^TV01XNZ1p){M1ONgM0uT}a1O)&F000RI2
nh)W2nhua00jsR2M7-c2oDbp2?GiZ00smC5Dy0s4hj(t2LcHW5eNwg2oMej01gTO0S^fR3=awk3kL)Z009U93k3oO1ONpG0uB!f3j+ob3J3=e4ha
MT1_1~P4G9bp2?h)W1PBQV1PBZf4iOI!4+#hf2nYcN2ml8K5e^3p2nrhr3k(MV0tEmM1P%lO0tW*O3j+lR5C9Gg3Je7d4Id8*0tyNc2M-7l2o47i
2LcHT0s{#E2LT5M0SyEU5C{ef4-X0g2MPcV2L}iN4hRPY5e^Um2MP)h1_}ZR7Y7Lk0v87Y3kVDd2ninr3IqrU5f1|n8wwK;4-5ej2Lb>E2>}QI6A
1_h1PBQP0|)>I0S5;H1`G%Y2nYiP1quiQ0R|BV0uBoW2MYub5D5?w0tpER3JeMd0|5XK3Iz-Y2nPTK3kVGb0SO2N4GRel0to^T1P}lK0t^HQ2nYx
W2><~A2N4Aj2MiGp5Cjhg5C{ec2nP%g1q=lb4<8E&2?7BN0t5sH2LuZU3?2Xx2@wGo2?GcT4g~-Y1qcNN3IP!W5d#JW3lIVb4+#PX5eESf01W^d0
0#&k2L}fS2>=8L3jhlU5CRbk4GRbl3<?Yh0to;B2@nAZ5CI4W3<w1X2LJ&C3k3iR01gHQ3=0Ai3LXju0tN{O2nYxW00RgJ2nYxW2mk~H2n7KV1OW
&K2nGTM1p)#9000FC3<m=O3l9td00#*X0SXHV2o4Aj0s{mA3j_xQ01pKK0s;yN3IhfP3IPxS2muKJ4+#nb2LJ~i1PKTa1_=xU4FL=k9}EZ#2?zlZ
2p0+o2nP%u2?GNM2nQVz2oVGd5EB9c1OWgJ2nYxT1qc8E1pxs901*rb4+sql0}llN01yfn01pug3;-Vi2oV4U5eEti2MG!c3Jehs3<D1W2pSFt2@
3!W2nh)Y4Gaw$4G9PU9{>ap0|EyD3IP!V0}T%c00saD1_&An1_=xi2p$mv10Dtd4+jef2LcTN0|WyA1`ZPn2@3%T2@DYr5dj7R0{{~b0t5gC1PKf
U5ef_j3kC=b3latb0uKNI3=aSb3JU=U5eNzf1OOft2MPuQ2LulX000LE3<>}W3<LrJ0s;XD3I+@i4+;VR6Ac3#4G<0t3=9YW3;_ob1P}oS4*?7T2
>=2H3K0qk3knGn1qKBQ1^@*B0|)~M0So{D4+sDY0t^TV2nY%c0|o#F2M`7X0TBQQ0RjvN3J3@d5EKds0tN;S016NY2oD$v00IC25d{eY3<d@W0tg
5Q0tf{N1OyHP0Rsja0SFER2@wqn5D@|f4h01S1px>I3j_-U1Q7uV1Of#R0|o;F0|)^F6$1+g1qToZ5fBCi1P})b00IsH7YzUa5E2Lk01OHV3JMSm
0RRdK0SOTb9102u2?+%Q4gwJY0tyNM3IPZP0{{UG0tf&I2?!Ga2mlBX2nY%Y4h#wj1P=fV0RjmD5CQ=R3=a<g1_22K3jz@i2n_%a4-f<g3=jYa1r
ZPo3<(Ab3<n4l3I-4j4GIDd2ml5V2?`7c3JDPr5fBj?1Pcfc5)BOr2NDbc3JL)a6AA_c2@nAc2nq-Y4<88x4-N?s0uBlY2?+`b2L}oS0|yHU0tOK
W0|yKp4-gFi0uK%X00;{L4GIJb3IYWP2nYfU2mlWg3<L)e9{>Of0{{sM2L=HL4FCuX4*&xT5CIAS4FCZR0|5vG2LS*G3JVGt00jyK1PuTX2?Y}Y0
SE~J5C#zp4*(7y4F?bj2LK2I0RsX902vAZ1rP!S5D5ti5exti3=a(p0T2fP01yTO1Q7xX0R;~c2LJ^I1q1{F5CjYf1_cHH1qKZZ5e5hc4gv-N4h{
<d3=0tt0tN&J4hRPa5D^do1_%)r4+;Yb5g8C05dr}i2N4JY1PBKJ1Of~Z2nPrV0|pBS2nq}l83_Xi1`Y@c0|^NX2mlBO9sv#q3jhlr4i6Io4F(Gg
1OfyE5Ca4N2m=oR0|N~U0}BKO3jzWK2m%5E3=snZ0tyQq2M7WT3j_%e2>}QP2nZ1f3JDJk4+IJV0RaUM3<?Sk4+RJa2m%NQ0}22H69NhW2>=2B2n
YcM0s;a600jvH0R##T1Plld0|E^Q0tyKQ4G#bZ1qTZU01*uY4g>=Q9~BA!00ayk000O85C#AZ6aohk4haDY5DEeY5C;$d3jqlc0|*ZY2ni4Z2m}W
J0tg5R2onSd1PKlR3lRVS3JMAe1qlli3j+xX5CZ@T0}2Na0R;sF5CRAX2nYxQ3kU-T2nh%X2L%ib0SXfV02cuO00IFY6b}Ic00aRO3J?(h5C{VZ4
Feeq2@wJS4*&@Z69)+b1r7-c2n+)X2MY=j2MY)h00s#V3J(n*
"""
"""Limit of each decision, uint8 as base85."""

LEAVES = """
ld|WJe*xr|)DflMurG1@#|E9t&q!zto3hLJ2S9HAqr2G&4@gLD@G8asLdpKK1JNwp44_x#>kz~L6wC=z;I7tD{KG8F1=lL#KH|y<tiR~U8=Waw#s
RYZ4#!9Fw$ke+C(Ti-wU-7h)2trB(Eib>JL<|H03o|psPei&1mhy^BDtuH^~fXUFYgPt#tYS|&s@C#0xQ(|&iC*z`xdVzuMYaF3ca)Ao&Cl22*2U
6;UYif=)DNQ>{!MJ|GfJ;tm7WJ`x4l%tr<qI0^h`+@gY9y0JH@*!uz89(6`<N11dJ!03F({pT)`h0og0ovlKJ60J9g`<GU4~3G^xDwg#Wg!QJr_0
V+H12jQ~xqwvb|0pSNa!34vWpW79+{<Rd_us{XW#-#zK{}m9*y8ofd+Pw49{}wRe_8I;;%t0}%0NottsMsx@{l*l|v*KIE=LG8_1t}S{@D~X@2G=
mI02t_~v;;rd{>Jnc0LPZ<-@DfD3G)y&$m#y%4cjyZ|G@+%y80>5{TSX1&k9iD#Ovz=`w}nn0p%&^1E8MW>8b_o|G_iV{xmPj-zcf>^$#ZR*08`6
2KA=w^E6A(0OT?B<flf?+5HgC0>dHh{Tce$`y)9G_65jM4>APA0qZ2?xCE;J{2eLfsrBbL_Z9pp%#T3G|GwN2zwS7y_!KSnx8L9`{R*<#wCw9x2l
prRsrED8{SL<kA;Tig+#vE)1kcMM?-v^H8eR_b2JaC0A>_9L_ZR#%0nVfV{}bRV2u{`t{~7$l!$JdL2lUbnwgBQm62b$@x&7m!1>{i^0qH39_zx-
fwHws{_!s>(&=;2C{uJF61=bE$0K@SS_q;>y{}0X}(KM<g{2(#w)D|=K{=f7PNAJ2N?+XfMCC=~!01o37$t0=`0pBa=9_hCT{|(g(zZx6T@(?ul3
*|-u^fI{`20#<}{vR&x@ip6{_zxcWwfh0A0V?rT$SIZp0O3{<4cE932=~lJ(GnB#0vG5TyC&2I`3x}N0KTIP^ak9C103ic!w0$|16&dO{Ru79Bjd
yP1lLU!D*f~f{S4~}Bmmm01Ls5n_DAah0@l*~vJbfR{s`r$48_o*{3R<0$|(WZ|H0V`>a*Gx{vjOn9qG}H%|4&<_XY~$0pjRV^Q~I*{@p4B@+2C_
^(Xi^_a@Q+^b{)l_#Qg?0qG?F&L$ky`z;4H_{kvu11iw~`pqcx2K~VH=|jQu1?~hMz9G>E4(H;n_zNoe%<v`S0Wb{n`3e-{@&pID0O}h7#ss$a{R
{di%Ipj90O%0>zX9Sl{|nzEF5@%n{s_n<)tyTK`WPes8oays01)pCxBC~i0p}nE{Vm)0{u~EA=`||F02CznBFjAh{SW`<_7*Jn`63iF2h9Ta_Y4y
Azx?@Y{|n_s&M=b&{}3D2<){h(>IxA{`Vubu{R=48*CGZ$|1bDE@;$If{tWXM!U%Hc0qPj`*PT7w01)|~w*vzJ13&x<#QE(n${_;pv=}Mc<pKjSK
m-8t{S_DG`7;010qHg94y-lH{udhhyd~$Sy(bC014#kv{?-2u@4ije{u%l%^DMs}p#C1W1pD>42lyuT#}w)!0xI(a71apO02Ipq8@=K-01Mb8y${
#~`wR`=5%@0l{|)%9(JJ`S{v872`!Ce|{Tm<c!2j-;xZMrw2lU+u{|ff15zCh80`=Z7EASPx_yP^k>AeCn{t3?mDA>mx0L}mp6ve+9{Td|v=ourn
_Y^7vOZ_(N{}%HJFwm#x`3fNd1>V&K`V9Xa1GFXJ04Oc;^H{X)$@c;m^av5V{U{XczX0GW0`46GAMh3F{sr;6(-;@sz3e6T0nGOy1=-#U?+Lf@2l
X%s|2p*)0`l=k4fZ0l5Zd_#@E9TM0`VK)+X6ei|0eK7B=%S90YyRjzaT;C0Or6l4ACI`{S8|d5?1=Y@CU^93N#b_1@{I({VXxv?!^@I0n`dI|KI)
z#P;(j{vR3WycRs({vtF7`3Bl5{u<W|GwAy$2>j6=7X!;D_%!>{2i+3@pz}1x1<wBo{^~ga`x)OP{SDv$2PW_$1N-c{>9slBzXSiy1o<xg0_V#8x
aL8<{|M+u;t;kC0n@bv*`d%B{so!==R2YN0Pge>?6u=T{|@*f>ZAr!<_h2l4gA#+|LG&~C-3GE{uCCv;zP@z01l}2x9`~;01oXbu=DXV1NbTM_9m
Y2`w$ZN-9ecE2i*GJ0wvD~{t6@U^eNQ@1>yZP4*26B{Swd$@g)!Z0v!P44cD_V`v?Ui1;)?;{t_<m^C>Q$2J;)@`65mO1N#`;-Yua3@B<TB_72ZD
0MHcxF5Ca^1Mk@)#1!BM^$Za6{0<St+c)RK9_af8{@Eeu0YCK?_y+nxuJ_<D{}=HA8PPou0q)Wj#}JbM0qGR~!uH@ezx?_LSq}To_dg2#{wnfL0`
Vo}{LwY<01yt^$RXV`68_Ku2JkWI^~w1+4(|B_{}dnh)H|p3`wR97tn1kd0n+C#;zsSC{@WD*&nsoZ0N<qL=Un8QA^FM#01yiC{}%l?2lnIz02KG
0^DnRV{~HQB;2amQ1Lp!r{UZ<V{1XKt{1EE=1MnE-^%E)o0@3v`9nVkh1nL4x_AU$g`xh4e#Sq~J`3wd1vH&m401*%Op#ADV12N?+`ZiYfHp}zD0
246#0s6)Ezxn7#2i@VR0P5}y0q^l2)+HkC1o#&N?LXTN0rUG38UywQ01EF3y$R+X3)cGxtpDgT01NG?`N7;P0rM#L7Ww)m{@@Ar{v7KM_S7o)0Sw
;)0U6W&{@xq?0O!>>3&idk0qgD?7xNXd^UwT31oPeg|J@n|_89)_{|PSnvH~Fh_XPv^Am&CC&ioYJ5c=r`{tEgV5!I^#0pb4&K+_Dz|0VV+{wn<D
`VJZS?ye0}>LLuz7wG#1|LyfU7Wl&&0vP<b>#*Si{3-q>Anf!8{}ce?AH6#P03Y-*0psNa{uTI2Lf!-G1N0*4^&R>o`wJHTFY*bk0Tcb5_|M$}0q
*Pv+@$#c_5$Aw@f<4K1LFVh;~o=40N)ky$rMD*0pcX(=Oq<%0`?~c{@D$x0O1h%o8j&{{ukvC5Bv|U{|5Q2sq+Q^
"""
"""Leaves, int8 as base85."""
